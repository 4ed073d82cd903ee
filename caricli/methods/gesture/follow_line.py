"""Handles, or the outline, that go to a line drawn over the face (sketch paper, section 3.3)."""

import cv2
import numpy as np
from scipy.sparse.csgraph import dijkstra, minimum_spanning_tree
from scipy.spatial.distance import cdist

from caricli.errors import InputError
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.match_line import resample
from caricli.geometry.lines.rows_at import rows_at
from caricli.geometry.lines.zero_lines import zero_lines
from caricli.methods.gesture.changed import Changed
from caricli.methods.gesture.held_deformation import held_deformation, sound_move
from caricli.methods.gesture.selection import Selection, around_handles, checked_stroke, mirror_map
from caricli.methods.gesture.settings import GestureSettings
from caricli.methods.gesture.sight import SeenStroke, Sight
from caricli.render.visibility.seen_points import seen_points
from caricli.structures import Camera, Face
from caricli.template.template import Template

_SAMPLES = 65
"""Of a drawn line and of a curve of handles."""
_SPINE = 8
"""Pieces of a curve of handles, each of which has a middle."""
_FINE = 8
_FINEST = 512
"""Pixels of the distance between handles, and at most of all of them, where the strip that they form is measured."""
_DISC = 0.75
"""Of the distance between handles, the radius of a disc around each; together they are a strip."""
_NEXT = 1.5
"""Times the longest gap between handles, up to which one is next to another."""
_SHORTEST = 1.0
"""Pixels that a line has at least."""
_HIDDEN = 0.012
"""Of the head's extent, that the surface may lie before an outline that is seen: facets of a coarse mesh do."""
_GAP = 0.06
"""Of the head's extent, that may be hidden between two parts of one outline."""
_LONGER = 2.5
"""Times that the part of the outline that a line is drawn for may be longer or shorter than the line."""


def follow_line(
    face: Face,
    template: Template,
    stroke: SeenStroke,
    selection: Selection,
    symmetric: bool = False,
    settings: GestureSettings = GestureSettings(),  # noqa: B008 (frozen)
) -> Changed:
    """Move handles in the view plane so that they meet a line; without handles, the outline of the face.

    Handles that form a curve are laid onto the line, end to end, in the direction that is nearer; a patch of them goes
    by the way from the line's beginning to its end, as published. Without handles the part of the outline within the
    region that is nearest to the line is laid onto it (Nealen et al. 2005). The rest of the region follows
    (``held_deformation``); depths of what is moved stay.

    face: Face. template: Template of its topology. stroke: SeenStroke. selection: Selection. symmetric: the same on the
    other side.
    Returns Changed. Raises InputError for a dot, and where no outline is near the line.
    """
    line = checked_stroke(stroke.points, 2)
    if np.linalg.norm(np.diff(line, axis=0), axis=1).sum() < _SHORTEST:
        raise InputError("expected a line, found a dot")
    if len(selection.handles):
        goals = handle_targets(face, stroke.camera, line, selection.handles, settings)
    else:
        goals = outline_targets(face, stroke.camera, line, selection, settings)
    return _moved(face, template, selection, goals, symmetric, settings)


def _moved(
    face: Face,
    template: Template,
    selection: Selection,
    goals: tuple[np.ndarray, np.ndarray],
    symmetric: bool,
    settings: GestureSettings,
) -> Changed:
    """The face with vertices at their goals: ids (K,), perhaps repeated, and places (K, 3)."""
    ids, targets = goals
    sums = np.zeros((len(face.vertices), 4))
    np.add.at(sums, ids, np.column_stack([targets - face.vertices[ids], np.ones(len(ids))]))
    own = selection.region if len(selection.region) else around_handles(face, ids, template.height, settings)
    region = np.zeros(len(face.vertices), bool)
    region[own] = True
    if symmetric:
        mirror = mirror_map(template)
        sums = sums + sums[mirror] * [-1, 1, 1, 1]
        region |= region[mirror]
    if not (region & (sums[:, 3] > 0)).any():
        raise InputError("expected handles within the region, found all of them outside")
    with np.errstate(invalid="ignore"):
        moves = sums[:, :3] / sums[:, 3:]
    length = settings.slope * template.height
    moved = held_deformation(face.vertices, face.faces, region, moves, length)
    vertices, share = sound_move(face.vertices, moved, region, template, settings)
    return Changed.of(face, vertices, share, region)


def handle_targets(
    face: Face, camera: Camera, line: np.ndarray, handles: np.ndarray, settings: GestureSettings
) -> tuple[np.ndarray, np.ndarray]:
    """Handles (K,) and where a line (N, 2) wants them (K, 3)."""
    own = face.vertices[handles]
    pixels = camera.project(own)
    spine = _spine(pixels, settings)
    if spine is None:
        return handles, camera.lift(pixels + line[-1] - line[0], own)
    shares, middles = spine
    drawn = resample(line, _SAMPLES)
    straight, turned = (np.linalg.norm(middles - each, axis=1).sum() for each in (drawn, drawn[::-1]))
    if turned < straight:
        drawn = drawn[::-1]
    there = np.linspace(0, 1, _SAMPLES)
    ways = rows_at(shares, there, drawn - middles)
    return handles, camera.lift(pixels + ways, own)


def _spine(pixels: np.ndarray, settings: GestureSettings) -> tuple[np.ndarray, np.ndarray] | None:
    """Shares (K,) of the way along the curve that handles at pixels (K, 2) form, and the curve (M, 2); None for a
    patch."""
    if len(pixels) < 3:
        return None
    apart = cdist(pixels, pixels)
    # The longest gap that must be bridged, and what is not longer by much, tells who is next to whom.
    gap = max(float(minimum_spanning_tree(np.maximum(apart, 1e-9)).data.max()), 1e-6)
    if _slenderness(pixels / gap) < settings.slender:
        return None
    ways = np.where(apart <= _NEXT * gap, np.maximum(apart, 1e-9), 0)
    start = int(np.linalg.norm(pixels - pixels.mean(0), axis=1).argmax())
    far = dijkstra(ways, indices=start)
    far = dijkstra(ways, indices=int(far.argmax()))
    count = min(_SPINE, len(pixels) // 2)
    pieces = np.rint(far / far.max() * count).astype(int)
    curve = np.array([pixels[pieces == piece].mean(0) for piece in range(count + 1) if (pieces == piece).any()])
    along = resample(curve, _SAMPLES)
    return np.linspace(0, 1, _SAMPLES)[cdist(pixels, along).argmin(1)], along


def _slenderness(points: np.ndarray) -> float:
    """How many times as long as wide the strip is that points (K, 2), neighbours of which are 1 apart, lie in.

    A strip of the length L and the width w, however bent, has the area L w and the perimeter 2 (L + w).
    """
    low = points.min(0) - 2
    zoom = min(_FINE, _FINEST / float(np.ptp(points, axis=0).max() + 4))
    mask = np.zeros(np.ceil((np.ptp(points, axis=0) + 4) * zoom).astype(int)[::-1], np.uint8)
    radius = max(round(_DISC * zoom), 1)
    for x, y in np.rint((points - low) * zoom).astype(int).tolist():
        cv2.circle(mask, (x, y), radius, 1, -1)
    rings, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    half = sum(cv2.arcLength(ring, True) for ring in rings) / 2
    area = sum(cv2.contourArea(ring) for ring in rings)
    root = np.sqrt(max(half**2 - 4 * area, 0))
    length, width = ((half + sign * root) / 2 - 2 * radius for sign in (1, -1))
    return float(length / max(width, radius))


def outline_targets(
    face: Face, camera: Camera, line: np.ndarray, selection: Selection, settings: GestureSettings
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (K,) on the outline and where a line (N, 2) wants them (K, 3). Raises InputError where none is near."""
    sight = Sight(face.mesh, camera)
    region = np.ones(len(face.vertices), bool)
    if len(selection.region):
        region[:] = False
        region[selection.region] = True
    drawn = resample(line, _SAMPLES)
    length = np.linalg.norm(np.diff(drawn, axis=0), axis=1).sum()
    best: tuple[float, np.ndarray, np.ndarray] | None = None
    for ids, points in _outlines(sight, region, drawn):
        away = np.linalg.norm(drawn[:, None] - points[None], axis=2)
        cost = float(away.min(1).mean())
        first, last = sorted((int(away[0].argmin()), int(away[-1].argmin())))
        own = np.linalg.norm(np.diff(points[first : last + 1], axis=0), axis=1).sum()
        if not length / _LONGER < own < length * _LONGER:
            continue
        if cost < settings.near * length and (best is None or cost < best[0]):
            best = cost, ids[first : last + 1], points[first : last + 1]
    if best is None:
        raise InputError("expected a line near the outline of the face within the region, found no outline there")
    _, ids, points = best
    if np.linalg.norm(points[0] - line[0]) > np.linalg.norm(points[-1] - line[0]):
        line = line[::-1]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    shares = np.concatenate([[0], np.cumsum(steps)]) / max(float(steps.sum()), 1e-12)
    drawn = resample(line, 4 * _SAMPLES)
    there = np.linspace(0, 1, len(drawn))
    places = rows_at(shares, there, drawn)
    own = face.vertices[ids]
    return ids, camera.lift(camera.project(own) + places - points, own)


def _outlines(sight: Sight, region: np.ndarray, drawn: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Parts of the outline that are seen within a region: vertices (N,) at it, and its points (N, 2).

    drawn: (M, 2) pixels of a line.
    """
    vertices = sight.mesh.vertices
    placed = sight.camera.place(vertices)
    extent = float(np.ptp(placed, axis=0).max())
    parts = []
    for chain in zero_lines(sight.facing, sight.mesh.faces):
        points = chain.of(placed)
        ids = np.where(chain.share < 0.5, chain.ends[:, 0], chain.ends[:, 1])
        seen = seen_points(points, placed, sight.mesh.faces, _HIDDEN * extent)
        closed = (chain.ends[0] == chain.ends[-1]).all()
        if closed:
            # A ring begins where it is seen, so that all that is hidden lies between two points that are.
            begin = int(seen.argmax())
            around = np.append(np.arange(begin, len(ids) - 1), np.arange(begin + 1))
            seen, ids, points = (each[around] for each in (seen, ids, points))
        shown = region[ids] & _bridged(seen, points, extent)
        if closed:
            # It is cut where it is not shown, or else away from the line, so that no part of it is cut there; this
            # point is in no part, or it would be in another one the other way round.
            turn = int(np.where(shown, cdist(points[:, :2], drawn).min(1), np.inf).argmax())
            shown, ids, points = (np.roll(each[:-1], -turn, axis=0) for each in (shown, ids, points))
            shown[0] = False
        borders = np.flatnonzero(np.diff(np.concatenate([[False], shown, [False]]).astype(int)))
        for start, end in borders.reshape(-1, 2):
            if end - start > 2:
                parts.append((ids[start:end], points[start:end, :2]))
    return parts


def _bridged(shown: np.ndarray, points: np.ndarray, extent: float) -> np.ndarray:
    """(N,) bool: what is seen of an outline, points (N, 3) pixels, with what is hidden only shortly."""
    seen = np.flatnonzero(shown)
    along = arc_lengths(points[:, :2])
    bridged = shown.copy()
    for start, end in zip(seen[:-1], seen[1:], strict=True):
        if along[end] - along[start] < _GAP * extent:
            bridged[start:end] = True
    return bridged
