"""Faces that can move."""
