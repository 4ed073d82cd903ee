"""Principal components of vertex positions."""
