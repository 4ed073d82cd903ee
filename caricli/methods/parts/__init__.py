"""Teeth, tongue and lashes of a face."""
