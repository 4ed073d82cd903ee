"""Sketches of faces: lines drawn from a mesh, and read from pictures."""
