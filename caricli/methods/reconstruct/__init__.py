"""Faces from landmarks."""
