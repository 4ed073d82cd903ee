"""Paths to values and back: every reader checks before it allocates, every writer is whole or absent."""
