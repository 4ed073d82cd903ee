"""Measurements of models and methods."""
