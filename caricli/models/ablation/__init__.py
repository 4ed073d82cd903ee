"""Rivals of the deformable model."""
