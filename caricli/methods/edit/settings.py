"""How faces are exaggerated."""

MODES = ("direction", "own")
"""Ways to exaggerate: along the direction of all caricatures, or away from the mean head."""
