"""Training of networks that paint: expressions and styles."""
