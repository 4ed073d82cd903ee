"""Faces in the terms of a shape model."""
