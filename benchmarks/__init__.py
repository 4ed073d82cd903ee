"""Figures with their commands: run the files here as scripts."""
