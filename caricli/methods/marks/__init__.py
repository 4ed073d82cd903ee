"""Landmarks that a hand places."""
