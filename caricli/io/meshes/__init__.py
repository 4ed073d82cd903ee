"""Meshes in every format but glTF, which has its own room."""
