"""Training of networks that see sketches."""
