"""What the pixels of a picture show."""

from enum import IntEnum


class Region(IntEnum):
    """What a pixel of a picture shows; the values stand in label maps."""

    BACKGROUND = 0
    SKIN = 1
    BROWS = 2
    EYES = 3
    NOSE = 4
    LIPS = 5
    MOUTH = 6
    TEETH = 7
    EARS = 8
    HAIR = 9
    BEARD = 10
    GLASSES = 11
    HAT = 12
    NECK = 13
    CLOTH = 14
    OTHER = 15
    """Hands, microphones and what else is held before a face."""


HEAD_REGIONS = (
    *(Region.SKIN, Region.BROWS, Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.EARS),
    *(Region.BEARD, Region.NECK),
)
"""What a head shows of itself, but for its hair."""

BEYOND = 255
"""Stands in label maps for what lies beyond the picture: nothing is told of it."""

REGION_COLOURS = (
    *((32, 32, 36), (232, 180, 148), (96, 60, 32), (250, 250, 250), (240, 150, 110), (214, 72, 88), (96, 16, 28)),
    *((255, 244, 200), (190, 120, 200), (120, 78, 40), (80, 120, 40), (40, 180, 220), (230, 160, 30)),
    *((200, 140, 120), (60, 90, 170), (130, 130, 140)),
)
"""sRGB that a label map is drawn in, by Region."""
