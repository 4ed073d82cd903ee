"""What drawing again is tuned by."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RedrawSettings:
    """How a picture is drawn again.

    fine: samples along a pixel. largest: samples, longest side of what is drawn so; beyond it fewer.
    still, moved: pixels, motion up to which a pixel stays as it is, and from which on it is drawn anew.
    changed: levels of 255, change of paint up to which a pixel that keeps still stays, and from which on it is drawn
    anew.
    band: share of the head's height in the picture, breadth of the strip beside an outline that goes with it: lines are
    drawn around a head, and no mesh ends where they do. stain: as band, breadth of what an outline that moved away may
    have left behind.
    line: as band, how far a drawn outline, and what is mixed at a border, reach into the head.
    jump: share of the head's height, difference of depth that makes an outline.
    narrow, wide: of the area that a triangle has in the new picture, the area in the old one up to which this showed
    nothing of it, and from which on it did.
    soft: pixels, standard deviation of the borders of what the label map shows.
    light: least and largest factor by which moved skin becomes darker and brighter.
    deep, teeth: shares of the light that reaches the depth of a mouth, and the darkest teeth.
    seam: of the colours of lips, those of the line between them.
    """

    fine: int = 2
    largest: int = 1600
    still: float = 0.2
    moved: float = 1.0
    changed: tuple[float, float] = (1.0, 4.0)
    band: float = 0.035
    stain: float = 0.02
    line: float = 0.006
    jump: float = 0.02
    narrow: float = 0.1
    wide: float = 0.3
    soft: float = 0.7
    light: tuple[float, float] = (0.75, 1.3)
    deep: float = 0.03
    teeth: float = 0.35
    seam: float = 0.45
