"""Pen gestures: strokes that say what to do with a surface (sketch paper, section 3.3)."""

GESTURES = (
    "line",
    "region",
    "left_arrow",
    "right_arrow",
    "up_roll_1",
    "up_roll_2",
    "up_roll_3",
    "down_roll_1",
    "down_roll_2",
    "down_roll_3",
)
"""Names. A roll is a line with one, two or three loops, which stand above it (up) or hang below it (down), however it
was drawn; an arrow a single stroke, with or without a shaft."""

LEVELS = 3
"""Of rolls."""


def roll_level(gesture: str) -> int:
    """How much a gesture bulges: 1 to 3 for an up roll, -1 to -3 for a down roll, 0 for all others."""
    if "_roll_" not in gesture:
        return 0
    return int(gesture[-1]) * (1 if gesture.startswith("up") else -1)
