"""Sketches as JSON and SVG."""
