"""Rigs that move over time."""
