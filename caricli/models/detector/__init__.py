"""Finds faces in a picture, with their landmarks and what every pixel shows."""
