"""What gestures are tuned by."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GestureSettings:
    """Sizes and weights, looked at on the mean head and on faces of pictures.

    behind: of a region's diameter, as far along the surface what is hidden belongs to it: the back of an ear does,
    the back of the head does not. reach: of the head's height, as far along the surface around handles everything may
    follow where no region is chosen. raised, pressed: of the region's radius, how far one, two and three rolls go;
    less inwards, where what stands out would go through itself. smooth: of the region's radius, over which normals
    are averaged, so that what bulges does not fan out or cross itself. fades: of the region's radius, in which what
    is hidden behind the skin is left behind when it is raised, the mouth behind lips, and when it is pressed in:
    there sockets would come through, if they stayed. slope: of the head's height, over which slopes at handles fade:
    as published, without an end, brows that are moved tear lids open. slender: handles at least so many times as long
    as wide are a curve, which is laid onto the line; others go as the line does. near: of the outline's points,
    distance in shares of the drawn line's length up to which they may be what the line is drawn for. bisections: of
    the way to the first triangle that turns over.
    """

    behind: float = 0.25
    reach: float = 0.2
    raised: tuple[float, float, float] = (0.15, 0.3, 0.5)
    pressed: tuple[float, float, float] = (0.1, 0.2, 0.3)
    smooth: float = 0.4
    fades: tuple[float, float] = (0.3, 1.2)
    slope: float = 0.03
    slender: float = 5.0
    near: float = 0.6
    bisections: int = 6
