"""From a sketch to a face."""
