"""Drawings on paper, photographed or scanned, as clean lines."""

from contextlib import suppress

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.trace_lines import InkLine
from caricli.methods.sketch.find_ink import find_ink
from caricli.methods.sketch.join_doubled import shades_along, trace_joined
from caricli.methods.sketch.page_frames import page_frames
from caricli.methods.sketch.settings import PaperSettings
from caricli.structures.sketch import CANVAS, Sketch, Stroke

_RIM = 0.15
"""Of a small drawing: how much paper around it is looked at, too."""


def clean_drawing(image: np.ndarray, settings: PaperSettings | None = None) -> Sketch:
    """The lines of a drawing, in the middle of a canvas of CANVAS pixels; their kinds are not known.

    Uneven light, shadows and the paper's grain are taken off, what lies around the paper is left out, and the ink that
    is left is thinned to lines, areas to their outlines; a frame around the drawing is none.

    image: (H, W, 3) uint8, dark lines on bright paper, or bright ones on dark. What is drawn on a small part of it is
    looked at anew, from near.
    Raises InputError where there are no lines, or areas rather than lines, as in a photograph.
    """
    settings = settings or PaperSettings()
    lines, side = _lines(image, settings)
    box = _box(lines)
    if np.ptp(box, axis=0).max() < settings.small * side:
        # From so near a thick pen may be none any more.
        with suppress(InputError):
            lines, _ = _lines(_around(image, box * max(image.shape[:2]) / side), settings)
            box = _box(lines)
    zoom = settings.fill * CANVAS / max(float(np.ptp(box, axis=0).max()), 1.0)
    aside = (CANVAS - 1) / 2 - zoom * box.mean(0)
    strokes = tuple(Stroke(zoom * line.points + aside, width=max(zoom * line.width, 1.0)) for line in lines)
    return Sketch(strokes)


def _lines(image: np.ndarray, settings: PaperSettings) -> tuple[list[InkLine], int]:
    """The lines of a picture (H, W, 3), at most so large as settings say, and the longer side that it has then, pixels.
    Raises InputError as above."""
    gray = _smaller(image, settings.side)
    if _is_chalk(gray, settings):
        gray = 1 - gray
    ink, dark = find_ink(gray, settings)
    longer = max(gray.shape)
    _refuse_colours(image, ink, settings)
    share = float(ink.mean())
    if share > settings.most or _solid(ink, settings.thick * longer).sum() > settings.solid * ink.sum():
        raise InputError(f"expected a drawing of lines on paper, found areas: {100 * share:.0f} % of it are dark")
    ink = _hollowed(ink, settings.area * longer)
    lines = _dark_lines(trace_joined(ink, settings.speck * longer), dark, settings.pale)
    frames = page_frames([line.points for line in lines])
    lines = _together([line for number, line in enumerate(lines) if number not in frames], settings.stray * longer)
    if sum(_length(line) for line in lines) < 0.1 * longer:
        raise InputError("expected a drawing of lines on paper, found hardly any line")
    return lines, longer


def _box(lines: list[InkLine]) -> np.ndarray:
    """(2, 2) the lower and the upper corner of the box around lines."""
    points = np.concatenate([line.points for line in lines])
    return np.stack([points.min(0), points.max(0)])


def _around(image: np.ndarray, box: np.ndarray) -> np.ndarray:
    """What of a picture (H, W, 3) lies in a box (2, 2) of pixels, and around it."""
    rim = _RIM * np.ptp(box, axis=0).max()
    low = np.maximum(np.floor(box[0] - rim), 0).astype(int)
    high = np.ceil(box[1] + rim).astype(int) + 1
    return image[low[1] : high[1], low[0] : high[0]]


def _smaller(image: np.ndarray, side: int) -> np.ndarray:
    """(H, W) brightness from 0 to 1, at most side pixels long."""
    import cv2

    gray = cv2.cvtColor(np.ascontiguousarray(image[..., :3]), cv2.COLOR_RGB2GRAY)
    zoom = side / max(gray.shape)
    if zoom < 1:
        size = (max(round(gray.shape[1] * zoom), 1), max(round(gray.shape[0] * zoom), 1))
        gray = cv2.resize(gray, size, interpolation=cv2.INTER_AREA)
    return gray.astype(np.float32) / 255


def _refuse_colours(image: np.ndarray, ink: np.ndarray, settings: PaperSettings) -> None:
    """Refuse what is of many colours beside its lines: paper is of one, and lines are thin."""
    import cv2

    size = (min(image.shape[1], 128), min(image.shape[0], 128))
    small = cv2.resize(np.ascontiguousarray(image[..., :3]), size, interpolation=cv2.INTER_AREA)
    bare = cv2.resize(ink.astype(np.float32), size, interpolation=cv2.INTER_AREA) == 0
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)[bare][:, 1:].astype(float)
    # The middle nine tenths, so that what else lies on the table does not count.
    if len(lab) and np.ptp(np.percentile(lab, (5, 95), axis=0), axis=0).max() > settings.colours:
        raise InputError("expected a drawing of lines on paper, found a picture of many colours")


def _is_chalk(gray: np.ndarray, settings: PaperSettings) -> bool:
    """Whether what stands out from its surroundings is rather bright than dark."""
    import cv2

    rest = gray - cv2.GaussianBlur(gray, (0, 0), settings.light * max(gray.shape) / 3)
    return bool((rest**3).mean() > 0.5 * max(float(rest.std()), 1e-6) ** 3)


def _dark_lines(lines: list[InkLine], dark: np.ndarray, pale: float) -> list[InkLine]:
    """Lines that are not much paler than the usual one: the others are shadows and folds of the paper."""
    lines = [line for line in lines if len(line.points) > 1]
    shades = shades_along(lines, dark)
    usual = float(np.median(np.concatenate([*shades, np.zeros(1)])))
    return [line for line, own in zip(lines, shades, strict=True) if np.median(own) > pale * usual]


def _length(line: InkLine) -> float:
    return float(arc_lengths(line.points)[-1])


def _together(lines: list[InkLine], short: float) -> list[InkLine]:
    """Lines without short ones beside all that are longer: dirt, and corners of shadows and of the paper."""
    longer = [line.points for line in lines if _length(line) > short]
    if not longer:
        return lines
    points = np.concatenate(longer)
    low, high = points.min(0), points.max(0)
    return [line for line in lines if ((line.points >= low) & (line.points <= high)).all(1).any()]


def _solid(ink: np.ndarray, radius: float) -> np.ndarray:
    """(H, W) bool: areas of the ink whose middle is further than a radius from paper."""
    import cv2

    core = (_depths(ink) > radius).astype(np.uint8)
    wide = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(radius) + 1,) * 2)).astype(bool)
    return wide & ink


def _depths(ink: np.ndarray) -> np.ndarray:
    """(H, W) pixels to the nearest paper."""
    import cv2

    return cv2.distanceTransform(np.pad(ink, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]


def _hollowed(ink: np.ndarray, radius: float) -> np.ndarray:
    """(H, W) bool: ink with areas whose middle is further than a radius from paper as their outlines."""
    return ink & ~(_solid(ink, radius) & (_depths(ink) > radius / 5))
