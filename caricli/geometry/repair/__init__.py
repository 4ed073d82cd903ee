"""What is wrong with a surface, and its mending: triangles turned over, holes, what goes through what."""
