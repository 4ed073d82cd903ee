"""Where in a sketch a face may lie, told by the boxes around strokes."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from caricli.methods.sketch.fit_lines import FRONT
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.settings import MIDDLE
from caricli.template.feature_curves import SILHOUETTE

_RARE = 0.01
"""Share of points at either side that may be far outside a face."""
_OPEN = 0.1
"""Of its height or width: the ends of a head's outline are nearer to each other."""
_CAP = 0.5
"""Of a head's width: hair that reaches over it is wider; a cat's ears are not."""
_BEYOND = 0.03
"""Of a head's height: hair or a neck reach farther over or below it."""


def faces_over(strokes: Sequence[np.ndarray], handles: LineHandles, mean: np.ndarray) -> list[np.ndarray]:
    """Lay a face over strokes without names, once for every part of a head that they may be the box of.

    That is a head with ears, one without, and a face without a crown; where no stroke goes around the others, features
    alone, with brows and without; and with an outline, or a jaw, as large as the largest stroke, and features where all
    others are, with ears, without, and without brows: jaws of caricatures have any size, but none is narrower than its
    features; and with the outline in a ring that hair or a neck leave.

    strokes: of (N, 2) pixels. handles: LineHandles. mean: (H, 3) of the face, in its own frame.
    Returns (H, 2) pixels of the handles for each.
    """
    flat = mean @ FRONT[:2].T
    every = np.arange(len(flat))
    head = np.setdiff1d(every, handles.rows_of("ear"))
    outline = handles.rows_of(SILHOUETTE)
    inside = np.setdiff1d(head, outline)
    lids = np.setdiff1d(inside, np.union1d(handles.rows_of("brow"), handles.rows_of("eye_fold")))
    boxes = [every, head]
    outlines = [outline]
    brows = handles.rows_of("brow")
    if len(brows):
        below = flat[:, 1] >= flat[brows, 1].min()
        boxes.append(head[below[head]])
        outlines.append(outline[below[outline]])
    strokes = sorted(strokes, key=lambda points: float(np.linalg.norm(np.ptp(points, axis=0))))
    if not _frames(strokes):
        boxes += [box for box in (inside, lids) if len(box)]
    laid = [_over(flat, box, strokes) for box in boxes]
    for features, part in product((every, head, lids), outlines):
        within = np.setdiff1d(features, outline)
        if len(strokes) > 1 and len(part) and len(within):
            placed = _over(flat, part, strokes[-1:])
            moved = inside if features is lids else within
            placed[moved] = _over(flat, within, strokes[:-1])[moved]
            # No face is narrower than what is in it.
            if np.ptp(placed[part, 0]) > np.ptp(placed[np.intersect1d(within, inside), 0]):
                laid.append(placed)
    return laid + _in_heads(flat, outline, (inside, lids), strokes)


def mouths_over(strokes: Sequence[np.ndarray], own: np.ndarray, handles: LineHandles) -> list[np.ndarray]:
    """Lay the mouth of a face over strokes between its nose and its chin: over the box of all, and of those in the
    middle.

    strokes: of (N, 2) pixels, that may draw a mouth. own: (H, 2) pixels of the handles of the face.
    Returns (H, 2) pixels of the handles for each; none where the face has no mouth, or nothing is drawn there.
    """
    lips, nose, outline = (handles.rows_of(name) for name in (*MIDDLE, SILHOUETTE))
    if not (len(lips) and len(nose) and len(outline)):
        return []
    least, most = own[outline].min(0), own[outline].max(0)
    below = [
        points
        for points in strokes
        if _middle(points)[1] > own[nose, 1].max() and points[:, 0].min() > least[0] and (points.max(0) < most).all()
    ]
    across = own[nose, 0].mean()
    central = [points for points in below if points[:, 0].min() < across < points[:, 0].max()]
    laid = []
    for group in (below, central):
        if group and np.ptp(np.concatenate(group), axis=0).all():
            laid.append(own.copy())
            laid[-1][lips] = _over(own, lips, group)[lips]
    return laid


def _in_heads(
    flat: np.ndarray, outline: np.ndarray, features: tuple[np.ndarray, ...], strokes: list[np.ndarray]
) -> list[np.ndarray]:
    """(H, 2) pixels of the handles with the outline in a ring that hair or a neck leave: as they are on the mean face,
    and with some features where all that is in the ring is. flat: (H, 2) of it. features: the first are all."""
    laid = []
    for ring, inner in _heads(strokes):
        laid.append(_over(flat, outline, [ring]))
        for rows in features:
            placed = laid[0].copy()
            placed[features[0]] = _over(flat, rows, inner)[features[0]]
            laid.append(placed)
    return laid


def _heads(strokes: list[np.ndarray]) -> list[tuple[np.ndarray, list[np.ndarray]]]:
    """A closed stroke that goes around most others, the smallest, and what is in it, where others reach over or below
    it: hair and a neck tell nothing of where features are."""
    for number, ring in enumerate(strokes):
        others = strokes[:number] + strokes[number + 1 :]
        if np.linalg.norm(ring[0] - ring[-1]) > _OPEN * np.ptp(ring, axis=0).max() or not _frames([*others, ring]):
            continue
        low, high = ring.min(0), ring.max(0)
        hair = [other[:, 1].min() for other in others if np.ptp(other[:, 0]) > _CAP * (high - low)[0]]
        beyond = max(low[1] - min(hair, default=low[1]), max(other[:, 1].max() for other in others) - high[1])
        inner = [other for other in others if (other.min(0) > low).all() and (other.max(0) < high).all()]
        return [(ring, inner)] if len(inner) > 1 and beyond > _BEYOND * (high - low)[1] else []
    return []


def _frames(strokes: list[np.ndarray]) -> bool:
    """Whether the last of some strokes goes around most others: as an outline does, and no feature."""
    low, high = strokes[-1].min(0), strokes[-1].max(0)
    middles = np.array([_middle(points) for points in strokes[:-1]]).reshape(-1, 2)
    return len(middles) > 0 and bool(((middles > low) & (middles < high)).all(1).mean() > 0.5)


def _middle(points: np.ndarray) -> np.ndarray:
    """(2,) of the box around points."""
    return (points.min(0) + points.max(0)) / 2


def _over(flat: np.ndarray, rows: np.ndarray, strokes: list[np.ndarray]) -> np.ndarray:
    """Points (H, 2) moved and scaled along each axis so that the box of those of rows is that of strokes."""
    low, high = np.quantile(np.concatenate(strokes), [_RARE, 1 - _RARE], axis=0)
    box = flat[rows]
    scale = (high - low) / np.ptp(box, axis=0)  # heads of caricatures are broad, or long
    return scale * (flat - (box.min(0) + box.max(0)) / 2) + (low + high) / 2
