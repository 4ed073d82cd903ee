"""What of a surface every pixel shows."""
