"""Strands of hair continued around a head, from strips of what is seen."""

import numpy as np

_WIDTHS = 20  # strips around the head
_OVERLAP = 0.4  # of a strip, with the one before
_SEEN = 0.5  # of a column: with less of it seen nothing is taken from there
_CANDIDATES = 160  # places that a strip may be taken from
_LIKELY = 1.1  # of the least difference: those with no more are drawn from, so that nothing repeats


def continue_strands(image: np.ndarray, seen: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Fill a picture that goes around, whose strands run down it, with strips of what is seen of it.

    Image quilting (Efros and Freeman 2001) in strips as high as the picture, so that every strand goes on from the
    first row to the last: a strip is taken where it differs least from what it joins, and joined along the cut of least
    difference.

    image: (R, C, 3), column C - 1 beside column 0. seen: (R, C) bool. generator: of the choice among equals.
    Returns (R, C, 3) float64, what is seen unchanged. All is its mean colour where too little is seen for a strip.
    """
    image = image.astype(np.float64)
    if not seen.any():
        return image
    whole = _complete_columns(image, seen)
    source = seen.mean(0) >= _SEEN * seen.mean(0).max()
    columns = image.shape[1]
    width = max(columns // _WIDTHS, 4)
    overlap = max(int(_OVERLAP * width), 2)
    strips = _strips(whole, source, width, generator)
    if source.all() or len(strips) == 0:
        return whole
    # The first column after something seen becomes the first of the picture.
    first = int(np.flatnonzero(source & ~np.roll(source, -1))[0]) + 1
    canvas = np.roll(whole, -first, axis=1)
    given = np.roll(source, -first)
    column = 0
    while column < columns:
        if given[column]:
            column += 1
            continue
        start = column - overlap
        place = np.arange(start, start + width) % columns
        fixed = given[place]
        chosen = _choose(strips, canvas[:, place], fixed, generator)
        canvas[:, place] = _joined(canvas[:, place], chosen, fixed, overlap)
        given[place] = True
        column = max(start + width, column + 1)
    filled = np.roll(canvas, first, axis=1)
    filled[seen] = image[seen]
    return filled


def _complete_columns(image: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """The picture with every column going on, to and fro, above and below its longest run that is seen."""
    rows = np.arange(len(image))
    whole = image.copy()
    for column in np.flatnonzero(seen.any(0)):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], seen[:, column], [0]]).astype(int)))
        runs = edges.reshape(-1, 2)
        start, end = runs[(runs[:, 1] - runs[:, 0]).argmax()]
        length = end - start
        along = np.mod(rows - start, 2 * length)
        row = start + np.minimum(along, 2 * length - 1 - along)
        whole[:, column] = np.where(seen[:, column, None], image[:, column], image[row, column])
    return whole


def _strips(whole: np.ndarray, source: np.ndarray, width: int, generator: np.random.Generator) -> np.ndarray:
    """(N, R, width, 3): strips of the picture all of whose columns are sources, and their mirror images."""
    ends = np.lib.stride_tricks.sliding_window_view(np.concatenate([source, source[: width - 1]]), width).all(1)
    starts = np.flatnonzero(ends)
    if len(starts) > _CANDIDATES // 2:
        starts = np.sort(generator.choice(starts, _CANDIDATES // 2, replace=False))
    places = (starts[:, None] + np.arange(width)) % len(source)
    strips = np.moveaxis(whole[:, places], 0, 1)
    return np.concatenate([strips, strips[:, :, ::-1]]).astype(np.float32)


def _choose(strips: np.ndarray, joined: np.ndarray, fixed: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """One of the strips that differ least from what they join (R, width, 3), where this is fixed (width,)."""
    if not fixed.any():
        return strips[generator.integers(len(strips))]
    differences = ((strips[:, :, fixed] - joined[:, fixed].astype(np.float32)) ** 2).mean((1, 2, 3))
    likely = np.flatnonzero(differences <= _LIKELY**2 * differences.min())
    return strips[generator.choice(likely)]


def _joined(before: np.ndarray, strip: np.ndarray, fixed: np.ndarray, overlap: int) -> np.ndarray:
    """A strip joined to what was there before (R, width, 3), on both sides where both are fixed (width,)."""
    width = len(fixed)
    result = strip.astype(np.float64)
    keep = np.zeros(result.shape[:2])
    left = overlap if fixed[:overlap].all() else 0
    right = width - int(np.argmin(fixed[::-1])) if fixed[-1] and not fixed.all() else width
    if left:
        keep[:, :left] = _cut(((before - result) ** 2).sum(-1)[:, :left])
    if right < width:
        keep[:, right:] = _cut(((before - result) ** 2).sum(-1)[:, right:][:, ::-1])[:, ::-1]
    if fixed.all():
        return before
    return keep[..., None] * before + (1 - keep[..., None]) * result


def _cut(differences: np.ndarray) -> np.ndarray:
    """(R, K) from 1 on the left to 0 on the right, of the cut of least difference from the top to the bottom."""
    rows, columns = differences.shape
    total = differences.copy()
    for row in range(1, rows):
        above = np.pad(total[row - 1], 1, constant_values=np.inf)
        total[row] += np.minimum(np.minimum(above[:-2], above[1:-1]), above[2:])
    path = np.zeros(rows, int)
    path[-1] = total[-1].argmin()
    for row in range(rows - 2, -1, -1):
        low = max(path[row + 1] - 1, 0)
        path[row] = low + total[row, low : path[row + 1] + 2].argmin()
    return np.clip((path[:, None] - np.arange(columns)) / 2 + 0.5, 0, 1)
