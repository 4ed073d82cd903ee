"""Training of the detector: windows of pictures, and what is asked of them."""
