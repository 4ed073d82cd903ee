"""Faces, landmarks and regions of pictures."""
