"""Ink on paper that was photographed or scanned."""

import numpy as np

from caricli.errors import InputError
from caricli.methods.sketch.settings import PaperSettings
from caricli.render.pixels.widen_mask import widen_mask

_ALL_OVER = 0.15
"""Share of an area that is ink from which on it is a pattern, as a table's grain is."""
_ALIKE = 0.25
"""Share by which the distances between most neighbours of ruled lines differ from the usual one, at most."""
_EDGE = 0.04
"""Of full brightness: a change within five pixels from which on something else begins."""


def find_ink(gray: np.ndarray, settings: PaperSettings) -> tuple[np.ndarray, np.ndarray]:
    """Ink on the paper, without the lines of ruled paper.

    gray: (H, W) from 0 to 1, dark lines on bright paper. settings: PaperSettings.
    Returns (H, W) bool, ink, and (H, W), the share of the paper's brightness by which everything is darker than it.
    Raises InputError for what is no paper.
    """
    import cv2
    from skimage.filters import apply_hysteresis_threshold

    longer = max(gray.shape)
    sheet = _sheet(gray, settings)
    soft = cv2.GaussianBlur(gray, (0, 0), max(longer / 1024, 0.5))
    _refuse_patterns(soft, sheet, settings)
    dark = 1 - soft / _light(soft, settings)
    level = float(np.median(dark[sheet]))
    spread = 1.4826 * float(np.median(np.abs(dark[sheet] - level)))
    low = max(settings.faint, settings.grain * spread) + level
    high = max(settings.ink, 1.6 * settings.grain * spread) + level
    ink = apply_hysteresis_threshold(dark, low, high)
    margin = max(round(settings.margin * longer), 1)
    if not _goes_on(ink, sheet, margin):
        ink &= ~widen_mask(~sheet, margin)
    return _without_ruling(ink, dark, settings), dark


def _light(soft: np.ndarray, settings: PaperSettings) -> np.ndarray:
    """(H, W) brightness of the paper: closed over what is wider than any line, so that lines vanish, and edges of
    shadows and folds of the paper stay; but of what is filled with ink, that of what is around it."""
    import cv2
    from skimage.morphology import reconstruction

    longer = max(soft.shape)
    reach = max(round(settings.light * longer / 2), 3) | 1
    light = _closed(soft, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach)))
    # Shadows come in from beyond the picture; what is filled with ink is a hole in the light.
    brim = np.full_like(light, light.max())
    brim[[0, -1]], brim[:, [0, -1]] = light[[0, -1]], light[:, [0, -1]]
    even = np.maximum(reconstruction(brim, light, method="erosion").astype(np.float32), 1e-3)
    _, holes, figures, _ = cv2.connectedComponentsWithStats((light < (1 - settings.ink) * even).astype(np.uint8))
    sizes = figures[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(1)
    dots = (holes > 0) & (sizes <= settings.dot * longer)[holes]
    return np.where(dots | (light < settings.black * even), even, np.maximum(light, 1e-3))


def _refuse_patterns(soft: np.ndarray, sheet: np.ndarray, settings: PaperSettings) -> None:
    """Refuse what differs everywhere from what is brightest nearby, as photographs and tilings do."""
    import cv2

    reach = max(round(settings.light * max(soft.shape)), 3) | 1
    around = cv2.dilate(soft, cv2.getStructuringElement(cv2.MORPH_RECT, (reach // 2 | 1, reach // 2 | 1)))
    dark = (1 - soft / np.maximum(cv2.blur(around, (reach, reach)), 1e-3))[sheet]
    if 1.4826 * float(np.median(np.abs(dark - np.median(dark)))) > settings.coarsest:
        raise InputError("expected a drawing of lines on paper, found areas or a pattern all over it")


def _goes_on(ink: np.ndarray, sheet: np.ndarray, margin: int) -> bool:
    """Whether lines go on where a sheet seems to end, at least two: a shadow falls on it there, and no table begins."""
    import cv2

    inside, outside = ~widen_mask(~sheet, margin), ~widen_mask(sheet, margin)
    border = ~inside & ~outside
    if not outside.any() or ink[outside].mean() > _ALL_OVER:
        return False
    _, pieces, figures, _ = cv2.connectedComponentsWithStats((ink & border).astype(np.uint8), connectivity=8)
    ends = [np.unique(pieces[widen_mask(ink & side, 1) & border]) for side in (inside, outside)]
    across = np.setdiff1d(np.intersect1d(ends[0], ends[1]), 0)
    # What runs along the border is the edge of a sheet.
    return int(np.count_nonzero(figures[across, cv2.CC_STAT_AREA] < (4 * margin) ** 2)) > 1


def _closed(gray: np.ndarray, element: np.ndarray) -> np.ndarray:
    """(H, W) without what is dark and narrower than an element; what lies at the border goes on beyond it."""
    import cv2

    around = max(element.shape)
    larger = cv2.copyMakeBorder(gray, around, around, around, around, cv2.BORDER_REPLICATE)
    return cv2.morphologyEx(larger, cv2.MORPH_CLOSE, element)[around:-around, around:-around]


def _without_ruling(ink: np.ndarray, dark: np.ndarray, settings: PaperSettings) -> np.ndarray:
    """(H, W) bool: ink without the lines of ruled or squared paper, which are straight, many, as far from each other,
    and paler than a pen."""
    import cv2

    shorter = min(ink.shape)
    lines = cv2.HoughLines(ink.astype(np.uint8), 1, np.pi / 360, int(settings.ruling * shorter))
    if lines is None:
        return ink
    distances, angles = lines[:, 0].T
    usual = np.radians(np.bincount(np.round(np.degrees(angles)).astype(int)).argmax())
    # At right angles to the usual direction, too; beside each other within a two-hundredth of the paper they are one.
    turned = np.abs((angles - usual + np.pi / 4) % (np.pi / 2) - np.pi / 4)
    along = turned < np.radians(1)
    places = np.unique(np.round(distances[along & (np.abs(angles - usual) < 0.1)] / (0.005 * shorter)))
    gaps = np.diff(places)[np.diff(places) > 1]
    # Through the strokes of a drawing that fills the paper straight lines go in all directions.
    if len(gaps) < settings.ruled - 1 or (turned < np.radians(3)).mean() < 0.5 or not _alike(gaps):
        return ink
    ruling = np.zeros(ink.shape, np.uint8)
    for distance, angle in zip(distances[along], angles[along], strict=True):
        foot = np.array([np.cos(angle), np.sin(angle)]) * distance
        way = np.array([-np.sin(angle), np.cos(angle)]) * 2 * max(ink.shape)
        cv2.polylines(ruling, [np.round([foot - way, foot + way]).astype(np.int32)], False, 1)
    pale = float(np.quantile(dark[(ruling > 0) & ink], 0.75))
    return ink & (dark > settings.bold * pale)


def _alike(gaps: np.ndarray) -> bool:
    """Whether most gaps (N,) are as wide as the usual one."""
    usual = float(np.median(gaps))
    return bool((np.abs(gaps - usual) <= _ALIKE * usual).mean() > 0.5)


def _sheet(gray: np.ndarray, settings: PaperSettings) -> np.ndarray:
    """(H, W) bool: the sheet, where it is told from a darker table; else everything."""
    import cv2
    from scipy.ndimage import binary_fill_holes

    longer = max(gray.shape)
    reach = max(round(settings.light * longer / 2), 3) | 1
    # Lines on the paper vanish.
    plain = _closed(gray, cv2.getStructuringElement(cv2.MORPH_RECT, (reach, reach)))
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
    return binary_fill_holes(_grown(sheet, plain))


def _grown(sheet: np.ndarray, plain: np.ndarray) -> np.ndarray:
    """(H, W) bool: a sheet, and what it shades off into without an edge: its far side stands in less light."""
    import cv2

    even = cv2.morphologyEx(plain, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) < _EDGE
    _, labels = cv2.connectedComponents(even.astype(np.uint8), connectivity=4)
    around = np.bincount(labels[sheet & even], minlength=1)
    if around[1:].sum() == 0:
        return sheet
    return sheet | (labels == 1 + int(around[1:].argmax()))
