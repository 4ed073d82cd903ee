"""Drawings on paper, photographed or scanned, as clean lines."""

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.trace_lines import InkLine
from caricli.methods.sketch.find_ink import find_ink
from caricli.methods.sketch.join_doubled import shades_along, trace_joined
from caricli.methods.sketch.page_frames import page_frames
from caricli.methods.sketch.settings import PaperSettings
from caricli.structures.sketch import CANVAS, Sketch, Stroke

_SPECK = 0.1
"""Of the longest piece of ink: what is smaller is no drawing beside it."""
_RIM = 0.15
"""Of a small drawing: how much paper around it is looked at, too."""
_SAME = 0.1
"""Of a small drawing: its box is no further from where it was when it is looked at from near."""


def clean_drawing(image: np.ndarray, settings: PaperSettings | None = None) -> Sketch:
    """The lines of a drawing, in the middle of a canvas of CANVAS pixels; their kinds are not known.

    Uneven light, shadows and the paper's grain are taken off, what lies around the paper is left out, and the ink that
    is left is thinned to lines, areas to their outlines; a frame around the drawing is none.

    image: (H, W, 3) uint8, dark lines on bright paper, or bright ones on dark. What is drawn on a small part of it is
    looked at anew, from near, and what fills it with paper around it.
    Raises InputError where there are no lines, or areas rather than lines, as in a photograph.
    """
    settings = settings or PaperSettings()
    lines, side = _lines(image, settings)
    share = np.ptp(_box(lines), axis=0).max() / side
    if not settings.small < share < settings.tight:
        lines = _from_near(image, lines, side, settings)
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
    extent = _extent(ink)
    ink = _hollowed(ink, settings.area * extent)
    lines = _dark_lines(trace_joined(ink, settings.speck * extent, extent), (dark, extent), settings.pale)
    frames = page_frames([line.points for line in lines])
    lines = _together([line for number, line in enumerate(lines) if number not in frames], settings.stray * extent)
    if sum(_length(line) for line in lines) < 0.1 * longer:
        raise InputError("expected a drawing of lines on paper, found hardly any line")
    return lines, longer


def _extent(ink: np.ndarray) -> float:
    """Pixels: the longer side of the box around ink (H, W) bool without specks, however much paper is around it."""
    import cv2

    figures = cv2.connectedComponentsWithStats(ink.astype(np.uint8), connectivity=8)[2][1:]
    if not len(figures):
        return float(max(ink.shape))
    low, size = figures[:, :2], figures[:, 2:4]
    large = size.max(1) > _SPECK * size.max()
    return float(np.ptp(np.vstack([low[large], (low + size)[large]]), axis=0).max())


def _box(lines: list[InkLine]) -> np.ndarray:
    """(2, 2) the lower and the upper corner of the box around lines."""
    points = np.concatenate([line.points for line in lines])
    return np.stack([points.min(0), points.max(0)])


def _from_near(image: np.ndarray, lines: list[InkLine], side: int, settings: PaperSettings) -> list[InkLine]:
    """The lines of what of a picture (H, W, 3) lies in their box and around it, where paper goes on beyond its borders;
    as they were where that is another drawing, as where a table begins close by, or none: from near a thick pen may be
    none any more. side: pixels, longer side of the picture that they are of."""
    import cv2

    box = _box(lines) * max(image.shape[:2]) / side
    rim = _RIM * np.ptp(box, axis=0).max()
    low, high = np.floor(box[0] - rim).astype(int), np.ceil(box[1] + rim).astype(int) + 1
    beyond = np.maximum([-low, high - image.shape[1::-1]], 0)
    part = image[max(low[1], 0) : high[1], max(low[0], 0) : high[0]]
    (left, top), (right, bottom) = beyond.tolist()
    part = cv2.copyMakeBorder(part, top, bottom, left, right, cv2.BORDER_REPLICATE)
    try:
        near, smaller = _lines(part, settings)
    except InputError:
        return lines
    away = low + _box(near) * max(part.shape[:2]) / smaller - box
    return near if np.abs(away).max() < _SAME * rim / _RIM else lines


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


def _dark_lines(lines: list[InkLine], dark: tuple[np.ndarray, float], pale: float) -> list[InkLine]:
    """Lines that are not much paler than the usual one: the others are shadows and folds of the paper. dark: (H, W),
    and the longer side of the drawing, pixels."""
    lines = [line for line in lines if len(line.points) > 1]
    shades = shades_along(lines, *dark)
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
