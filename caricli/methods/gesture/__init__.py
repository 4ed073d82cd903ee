"""Strokes on a face, seen from any side, that change its surface (sketch paper, sections 3.3 and 5.2)."""
