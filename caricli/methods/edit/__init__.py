"""Faces changed as a user asks."""
