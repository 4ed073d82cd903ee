"""Datasets: build, import, read."""
