"""Textures that follow the expression (expressions paper, section 3.3)."""
