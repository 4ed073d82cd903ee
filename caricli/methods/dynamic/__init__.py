"""Textures that follow the expression."""
