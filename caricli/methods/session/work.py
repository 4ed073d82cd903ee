"""What is worked on in a session."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from caricli.methods.faces.encode_face import EncodedFace
from caricli.structures import Landmarks, Sketch, Stroke

CANVAS_SIDE = 512
"""Pixels, width and height of the canvas that is drawn on."""


@dataclass(frozen=True)
class Gap:
    """What is erased of a line of the face. curve: its name. first, last: points of the line where it is open; of a
    closed line the last may lie beyond its end, on the next round.
    """

    curve: str
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Work:
    """All that operations change; every one of them gives another Work.

    face: EncodedFace at rest, without the expression below; in the camera of the canvas or of the picture, where there
    is one. sketch: Sketch, the lines of the modes Draw and Redraw, on a canvas of ``CANVAS_SIDE`` or the picture.
    picture: (H, W, 3) uint8 that is drawn over and landmarks lie on, or None. landmarks: Landmarks, or None.
    weights: of ARKit's actions by name, 0 to 1, those that are not 0. strengths: standard deviations that the face went
    by labels since it was drawn. handles: (H,) ids of the vertices that are marked for gestures. region: (R,) ids of
    the vertices that gestures may move, or None for all. skin: (S,) those of them that were seen when they were chosen.
    gap: Gap in the lines of the mode Redraw, or None. wrinkles: Strokes beside these, on a canvas of ``CANVAS_SIDE``.
    remark: what is to be said of the last operation, such as how far it went; empty where nothing is.
    """

    face: EncodedFace
    sketch: Sketch = Sketch(size=(CANVAS_SIDE, CANVAS_SIDE))  # noqa: RUF009 (frozen)
    picture: np.ndarray | None = None
    landmarks: Landmarks | None = None
    weights: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    strengths: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    handles: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    region: np.ndarray | None = None
    skin: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    gap: Gap | None = None
    wrinkles: tuple[Stroke, ...] = ()
    remark: str = ""
