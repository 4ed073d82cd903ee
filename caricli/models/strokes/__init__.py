"""The network that tells which curve of a face every place along a stroke draws."""
