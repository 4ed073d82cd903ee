"""Drawings on paper, photographed or scanned, as clean lines."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.trace_lines import InkLine, trace_lines
from caricli.methods.sketch.page_frames import page_frames
from caricli.render.pixels.widen_mask import widen_mask
from caricli.structures.sketch import CANVAS, Sketch, Stroke

_EDGE = 0.04
"""Of full brightness: a change within five pixels from which on something else begins."""


@dataclass(frozen=True)
class PaperSettings:
    """What is ink on paper. Lengths are shares of the longer side of the picture.

    side: pixels that larger pictures are made smaller to. light: over how far light and paper change. grain: how many
    times as dark as the paper's grain ink is at least. faint, ink: least darkness, of the paper's brightness, that
    continues a line and that begins one. pale: darkness of a line, of the usual one's, at least. speck: of a line, what
    is shorter is dirt. thick: half the width of the widest line. solid: share of the ink that may be wider. most: share
    of the paper that lines cover at most. coarsest: grain, of the paper's brightness, that paper has at most. ruling:
    of the shorter side, ink along a straight line of the paper's own. ruled: how many of one direction there are at
    least. bold: how many times as dark as these what is drawn on ruled paper is at least. colours: how far, in steps of
    Lab, it may change its colour. table: how much brighter the paper is than what lies around it, where it is told from
    it. fill: of the canvas, the longer side of the drawing.
    """

    side: int = 1024
    light: float = 0.09
    grain: float = 3.5
    faint: float = 0.05
    ink: float = 0.11
    pale: float = 0.35
    speck: float = 0.012
    thick: float = 0.014
    solid: float = 0.35
    most: float = 0.3
    coarsest: float = 0.09
    ruling: float = 0.4
    ruled: int = 6
    bold: float = 1.4
    colours: float = 40.0
    table: float = 1.35
    fill: float = 0.86


def clean_drawing(image: np.ndarray, settings: PaperSettings | None = None) -> Sketch:
    """The lines of a drawing, in the middle of a canvas of CANVAS pixels; their kinds are not known.

    Uneven light and the paper's grain are taken off, what lies around the paper is left out, and the ink that is left
    is thinned to lines; a frame around the drawing is none.

    image: (H, W, 3) uint8, dark lines on bright paper, or bright ones on dark.
    Raises InputError where there are no lines, or areas rather than lines, as in a photograph.
    """
    settings = settings or PaperSettings()
    gray = _smaller(image, settings.side)
    if _is_chalk(gray, settings):
        gray = 1 - gray
    ink, dark = _ink(gray, settings)
    longer = max(gray.shape)
    ink = _without_ruling(ink, dark, settings)
    _refuse_colours(image, ink, settings)
    share = float(ink.mean())
    if share > settings.most or _solid(ink, settings.thick * longer) > settings.solid:
        raise InputError(f"expected a drawing of lines on paper, found areas: {100 * share:.0f} % of it are dark")
    lines = _dark_lines(trace_lines(ink, settings.speck * longer), dark, settings.pale)
    frames = page_frames([line.points for line in lines])
    lines = [line for number, line in enumerate(lines) if number not in frames]
    if sum(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum() for line in lines) < 0.1 * longer:
        raise InputError("expected a drawing of lines on paper, found hardly any line")
    points = np.concatenate([line.points for line in lines])
    zoom = settings.fill * CANVAS / max(float(np.ptp(points, axis=0).max()), 1.0)
    aside = (CANVAS - 1) / 2 - zoom * (points.min(0) + points.max(0)) / 2
    strokes = tuple(Stroke(zoom * line.points + aside, width=max(zoom * line.width, 1.0)) for line in lines)
    return Sketch(strokes)


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
    bare = cv2.resize(ink.astype(np.uint8), size, interpolation=cv2.INTER_AREA) == 0
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
    shades = [dark[tuple(line.points.round().astype(int).T[::-1])] for line in lines]
    usual = float(np.median(np.concatenate([*shades, np.zeros(1)])))
    return [line for line, own in zip(lines, shades, strict=True) if np.median(own) > pale * usual]


def _ink(gray: np.ndarray, settings: PaperSettings) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) bool, ink on the paper, and (H, W), by how much darker than the paper everything is."""
    import cv2
    from skimage.filters import apply_hysteresis_threshold

    longer = max(gray.shape)
    paper = _paper(gray, settings)
    soft = cv2.GaussianBlur(gray, (0, 0), max(longer / 1024, 0.5))
    # The brightest nearby is paper, whatever was drawn on it; grain makes single pixels too bright, so after a blur.
    reach = max(round(settings.light * longer), 3) | 1
    around = cv2.dilate(soft, cv2.getStructuringElement(cv2.MORPH_RECT, (reach // 2 | 1, reach // 2 | 1)))
    light = cv2.blur(around, (reach, reach))
    dark = 1 - soft / np.maximum(light, 1e-3)
    level = float(np.median(dark[paper])) if paper.any() else 0.0
    spread = 1.4826 * float(np.median(np.abs(dark[paper] - level))) if paper.any() else 0.0
    if spread > settings.coarsest:
        raise InputError("expected a drawing of lines on paper, found areas or a pattern all over it")
    low = max(settings.faint, settings.grain * spread) + level
    high = max(settings.ink, 1.6 * settings.grain * spread) + level
    return apply_hysteresis_threshold(dark, low, high) & paper, dark


def _without_ruling(ink: np.ndarray, dark: np.ndarray, settings: PaperSettings) -> np.ndarray:
    """(H, W) bool: ink without the lines of ruled or squared paper, which are straight, many, and paler than a pen."""
    import cv2

    shorter = min(ink.shape)
    lines = cv2.HoughLines(ink.astype(np.uint8), 1, np.pi / 360, int(settings.ruling * shorter))
    if lines is None:
        return ink
    distances, angles = lines[:, 0].T
    usual = np.radians(np.bincount(np.round(np.degrees(angles)).astype(int)).argmax())
    # At right angles to the usual direction, too; beside each other within a two-hundredth of the paper they are one.
    along = np.abs((angles - usual + np.pi / 4) % (np.pi / 2) - np.pi / 4) < np.radians(1)
    places = np.unique(np.round(distances[along & (np.abs(angles - usual) < 0.1)] / (0.005 * shorter)))
    if np.count_nonzero(np.diff(places) > 1) < settings.ruled - 1:
        return ink
    ruling = np.zeros(ink.shape, np.uint8)
    for distance, angle in zip(distances[along], angles[along], strict=True):
        foot = np.array([np.cos(angle), np.sin(angle)]) * distance
        way = np.array([-np.sin(angle), np.cos(angle)]) * 2 * max(ink.shape)
        cv2.polylines(ruling, [np.round([foot - way, foot + way]).astype(np.int32)], False, 1)
    pale = float(np.quantile(dark[(ruling > 0) & ink], 0.75))
    return ink & (dark > settings.bold * pale)


def _paper(gray: np.ndarray, settings: PaperSettings) -> np.ndarray:
    """(H, W) bool: the sheet, where it is told from a darker table, without its edge; else everything."""
    import cv2

    longer = max(gray.shape)
    reach = max(round(settings.light * longer / 2), 3) | 1
    # Lines on the paper vanish.
    plain = cv2.morphologyEx(gray, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_RECT, (reach, reach)))
    bytes_ = np.round(255 * plain).astype(np.uint8)
    level, bright = cv2.threshold(bytes_, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    count, labels, figures, _ = cv2.connectedComponentsWithStats(bright, connectivity=4)
    everything = np.ones(gray.shape, bool)
    if count < 2:
        return everything
    largest = 1 + int(np.argmax(figures[1:, cv2.CC_STAT_AREA]))
    sheet = labels == largest
    rest = plain[~sheet]
    told = sheet.mean() > 0.2 and rest.size and np.median(plain[sheet]) > settings.table * np.median(rest)
    # A shadow over the paper is no table: a table has an edge, where brightness falls within a few pixels.
    edge = widen_mask(sheet, 2) & ~sheet
    near = widen_mask(~sheet, 2) & sheet
    steep = edge.any() and np.median(plain[near]) - np.median(plain[edge]) > 0.08
    if not (told and steep):
        return everything
    sheet = _grown(sheet, plain)
    filled = cv2.morphologyEx(sheet.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((reach, reach), np.uint8))
    return cv2.erode(filled, np.ones((reach, reach), np.uint8), borderValue=0).astype(bool)


def _grown(sheet: np.ndarray, plain: np.ndarray) -> np.ndarray:
    """(H, W) bool: a sheet, and what it shades off into without an edge: its far side stands in less light."""
    import cv2

    even = cv2.morphologyEx(plain, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) < _EDGE
    _, labels = cv2.connectedComponents(even.astype(np.uint8), connectivity=4)
    around = np.bincount(labels[sheet & even], minlength=1)
    if around[1:].sum() == 0:
        return sheet
    return sheet | (labels == 1 + int(around[1:].argmax()))


def _solid(ink: np.ndarray, radius: float) -> float:
    """Share of the ink that is further than a radius from paper."""
    import cv2

    if not ink.any():
        return 0.0
    inside = cv2.distanceTransform(np.pad(ink, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]
    core = (inside > radius).astype(np.uint8)
    wide = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(radius) + 1,) * 2)).astype(bool)
    return float((wide & ink).sum() / ink.sum())
