"""Lines of ink as strokes."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths

_AHEAD = 8
"""Pixels from its end that say in which direction a line goes."""
_STRAIGHT = -0.6
"""Cosine between the ways out of a crossing along two lines up to which they are one line."""
_SMOOTH = 2.0
"""Pixels: standard deviation of the smoothing that takes the steps of pixels off."""
_STEP = 3
"""Pixels between the points of a line."""


@dataclass(frozen=True, eq=False)
class InkLine:
    """A line of ink. points: (N, 2) pixels, x right, y down. width: pixels."""

    points: np.ndarray
    width: float


@dataclass(eq=False)
class _Branch:
    """A line between crossings. pixels: (N, 2) int rows and columns. ends: crossings at its start and end, or -1."""

    pixels: np.ndarray
    ends: tuple[int, int]


def trace_lines(ink: np.ndarray, shortest: float) -> list[InkLine]:
    """The middles of lines of ink, each from end to end, straight on where lines cross.

    ink: (H, W) bool. shortest: pixels; shorter lines, and stubs of that length at others, are left out.
    Returns InkLines, the longest first; those of the mirrored ink are their mirror images.
    """
    import cv2
    from skimage.morphology import skeletonize

    if not ink.any():
        return []
    if _is_mirrored(ink):
        lines = trace_lines(np.ascontiguousarray(ink[:, ::-1]), shortest)
        return [InkLine(np.array([ink.shape[1] - 1, 0]) + [-1, 1] * line.points, line.width) for line in lines]
    inside = cv2.distanceTransform(np.pad(ink, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    thin = skeletonize(ink)
    branches, centres = _branches(thin)
    branches, centres = _merged([branch for branch in branches if not _is_stub(branch, shortest)], centres, inside)
    lines = []
    for chain in _joined(branches, centres):
        width = 2 * float(np.median(inside[tuple(chain.astype(int).T)])) - 1
        if _length(chain) > shortest:
            lines.append(InkLine(_smoothed(chain[:, ::-1].astype(np.float64)), width))
    return sorted(lines, key=lambda line: -_length(line.points))


def _is_mirrored(ink: np.ndarray) -> bool:
    """Whether of ink (H, W) and its mirror image the other one is traced: thinning is not alike on both sides."""
    columns = np.trim_zeros(ink.sum(0))
    differ = np.flatnonzero(columns != columns[::-1])
    return len(differ) > 0 and bool(columns[differ[0]] > columns[::-1][differ[0]])


def _length(pixels: np.ndarray) -> float:
    """Of a line through pixels (N, 2), from border to border."""
    return 1 + float(arc_lengths(pixels)[-1])


def _is_stub(branch: _Branch, shortest: float) -> bool:
    free = sum(end < 0 for end in branch.ends)
    return _length(branch.pixels) < shortest and free > 0


def _merged(branches: list[_Branch], centres: np.ndarray, inside: np.ndarray) -> tuple[list[_Branch], np.ndarray]:
    """The same with two crossings of three lines as one where the discs of ink around them overlap: what two lines that
    cross at a sharp angle leave, which run together for a while; and what three leave that meet at a corner. inside:
    (H, W) pixels to the border of the ink."""
    import cv2

    # The middle of a crossing may be a pixel or two off the ink's.
    reach = cv2.dilate(inside, np.ones((5, 5), np.uint8))[tuple(centres.round().astype(int).T)]
    at: dict[int, list[tuple[_Branch, int]]] = {}
    for branch in branches:
        for side, end in enumerate(branch.ends):
            at.setdefault(end, []).append((branch, side))
    middles = centres.copy()
    other: dict[int, int] = {}
    moved_ends: set[int] = set()
    further = []
    for branch in branches:
        first, last = branch.ends
        sharp = first != last and min(branch.ends) >= 0 and len(branch.pixels) < reach[first] + reach[last]
        forks = sharp and len(at[first]) == len(at[last]) == 3
        if (forks or (sharp and _is_tip(branch, at, centres))) and moved_ends.isdisjoint(branch.ends):
            moved_ends.update(branch.ends)
            other[last] = first
            middles[first] = (centres[first] + centres[last]) / 2
        else:
            further.append(branch)
    moved = [tuple(other.get(end, end) for end in branch.ends) for branch in further]
    return [
        _Branch(branch.pixels, (first, last)) for branch, (first, last) in zip(further, moved, strict=True)
    ], middles


def _is_tip(branch: _Branch, at: dict[int, list[tuple[_Branch, int]]], centres: np.ndarray) -> bool:
    """Whether a short branch leads from where two lines part to a corner from which a third one turns back, as lips and
    the line between them meet. at: branches with the side that ends at each crossing. centres: (K, 2) of these."""
    ends = sorted(branch.ends, key=lambda end: len(at[end]))
    if [len(at[end]) for end in ends] != [2, 3]:
        return False
    first, second = (_way(b.pixels, side, centres[ends[0]]) for b, side in at[ends[0]])
    return float(first @ second) > _STRAIGHT


def _branches(thin: np.ndarray) -> tuple[list[_Branch], np.ndarray]:
    """Lines between crossings, and the middles (K, 2) of these."""
    import cv2

    around = cv2.filter2D(thin.astype(np.uint8), -1, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_CONSTANT) - 1
    crossing = thin & (around >= 3)
    count, labels, _, middles = cv2.connectedComponentsWithStats(crossing.astype(np.uint8), connectivity=8)
    left = thin & ~crossing
    places = {(int(r), int(c)) for r, c in np.argwhere(left)}
    branches = []
    # From ends first, so that a line is followed whole; what is left then are rings.
    ordered = sorted(places, key=lambda place: (len(_next_to(place, places)) != 1, place))
    seen: set[tuple[int, int]] = set()
    for start in ordered:
        if start in seen:
            continue
        path = [start]
        seen.add(start)
        while True:
            further = [place for place in _next_to(path[-1], places) if place not in seen]
            if not further:
                break
            # Straight neighbours before diagonal ones, so that no pixel of a corner is left behind.
            place = min(further, key=lambda p: (abs(p[0] - path[-1][0]) + abs(p[1] - path[-1][1]), p))
            # The others of a corner are its inside, but where a ring begins the other way is its end.
            seen.update(p for p in further if len(path) > 1 and max(abs(p[0] - place[0]), abs(p[1] - place[1])) < 2)
            seen.add(place)
            path.append(place)
        ends = _ends(path, labels)
        if len(path) > 6 and ends == (-1, -1) and path[0] in _next_to(path[-1], places):
            path.append(path[0])
        branches.append(_Branch(np.array(path), ends))
    return branches, middles[:count, ::-1]


def _next_to(place: tuple[int, int], places: set[tuple[int, int]]) -> list[tuple[int, int]]:
    r, c = place
    around = ((r + i, c + j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)
    return [other for other in around if other in places]


def _ends(path: list[tuple[int, int]], labels: np.ndarray) -> tuple[int, int]:
    """Crossings at the start and the end of a branch, or -1."""
    starts, ends = (_crossings_at(place, labels) for place in (path[0], path[-1]))
    first, last = (max(here, default=-1) for here in (starts, ends))
    if first != last or len(path) > 2:
        return first, last
    # So short that both of its ends are near to one crossing: it leads to another, or nowhere.
    return max(starts - {last}, default=-1), last


def _crossings_at(place: tuple[int, int], labels: np.ndarray) -> set[int]:
    r, c = place
    return set(labels[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].ravel().tolist()) - {0}


def _joined(branches: list[_Branch], centres: np.ndarray) -> list[np.ndarray]:
    """Chains (N, 2) of branches that go straight on over a crossing."""
    at: dict[int, list[tuple[int, int]]] = {}
    for number, branch in enumerate(branches):
        for side, end in enumerate(branch.ends):
            if end >= 0:
                at.setdefault(end, []).append((number, side))
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    for crossing, ends in at.items():
        ways = {end: _way(branches[end[0]].pixels, end[1], centres[crossing]) for end in ends}
        pairs = sorted(
            (float(ways[a] @ ways[b]), a, b) for k, a in enumerate(ends) for b in ends[k + 1 :] if a[0] != b[0]
        )
        for cosine, a, b in pairs:
            if len(ends) == 2 or cosine < _STRAIGHT:
                if a not in partner and b not in partner:
                    partner[a] = b
                    partner[b] = a
    chains = []
    used: set[int] = set()
    free = [(n, side) for n in range(len(branches)) for side in (0, 1) if (n, side) not in partner]
    for start in [*free, *((n, 0) for n in range(len(branches)))]:
        if start[0] not in used:
            chains.append(_walk(start, branches, partner, (centres, used)))
    return chains


def _walk(
    start: tuple[int, int],
    branches: list[_Branch],
    partner: dict[tuple[int, int], tuple[int, int]],
    state: tuple[np.ndarray, set[int]],
) -> np.ndarray:
    """Pixels from an end of a branch on, over crossings. state: middles of crossings, and branches that are used."""
    centres, used = state
    pieces: list[np.ndarray] = []
    number, side = start
    while number not in used:
        used.add(number)
        branch = branches[number]
        pixels = branch.pixels if side == 0 else branch.pixels[::-1]
        first, last = branch.ends if side == 0 else branch.ends[::-1]
        if first >= 0:
            pieces.append(centres[first][None])
        pieces.append(pixels)
        if last >= 0:
            pieces.append(centres[last][None])
        if (number, 1 - side) not in partner:
            break
        number, side = partner[number, 1 - side]
    return np.concatenate(pieces).round()


def _way(pixels: np.ndarray, side: int, centre: np.ndarray) -> np.ndarray:
    """(2,) unit: the way from a crossing along a line."""
    ahead = pixels[: _AHEAD + 1] if side == 0 else pixels[::-1][: _AHEAD + 1]
    way = ahead[-1] - centre
    return way / max(float(np.linalg.norm(way)), 1e-9)


def _smoothed(points: np.ndarray) -> np.ndarray:
    from scipy.ndimage import gaussian_filter1d

    closed = len(points) > 6 and np.abs(points[0] - points[-1]).max() <= 1.5
    smooth = gaussian_filter1d(points, _SMOOTH, axis=0, mode="wrap" if closed else "nearest")
    if not closed:
        smooth[[0, -1]] = points[[0, -1]]
    picked = np.unique(np.append(np.arange(0, len(smooth), _STEP), len(smooth) - 1))
    line = smooth[picked]
    return np.vstack([line, line[:1]]) if closed else line
