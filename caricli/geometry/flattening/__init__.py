"""Surfaces in the plane."""
