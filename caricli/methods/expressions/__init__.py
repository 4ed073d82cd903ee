"""Expressions that keep who a face is."""
