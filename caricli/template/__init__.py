"""The head, its annotation and its cache."""
