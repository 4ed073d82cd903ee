"""The frame of every shape in files: what its lengths are in, and where its axes point."""

UNITS = "m"
AXES = "+y up, +z front"
