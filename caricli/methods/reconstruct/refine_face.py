"""A face aligned exactly with the landmarks of its picture (portrait paper, section 3.2.2)."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.laplacian_deformation import LaplacianDeformation
from caricli.geometry.slide_contour import slide_contour
from caricli.geometry.untangle import untangle
from caricli.methods.reconstruct.fit_landmarks import JAW, PARTS

OPPOSITE = ((37, 41), (38, 40), (43, 47), (44, 46), (61, 67), (62, 66), (63, 65))
"""Landmarks of upper and lower lids, and of the inside of upper and lower lip: they may meet, but not pass."""

CORNERS = ((48, 60), (54, 64))
"""Outer and inner corner of the mouth, which many mark in one place."""

FARTHEST, CROSSED, LIPS_CROSSED, SAME, STILL = 0.25, 0.02, 0.06, 1e-4, 1e-6


@dataclass(frozen=True, eq=False)
class Refinement:
    """vertices (V, 3) metres; landmarks (L, 2) where they project to, pixels; anchors (L,) their vertex ids; before and
    after, mean errors by part and "all" in percent of the diagonal of the given landmarks; moved, the longest way of a
    vertex, metres; flipped, share of triangles."""

    vertices: np.ndarray
    landmarks: np.ndarray
    anchors: np.ndarray
    before: dict
    after: dict
    moved: float
    flipped: float


def refine_face(vertices, pose, points, template, weight=1.0, laplacian="cotangent"):
    """Move the landmarks' vertices onto their landmarks in the picture, at their depth, and the surface along.

    vertices: (V, 3) metres. pose: Camera of the picture. points: (L, 2) pixels, NaN where unknown. template: Template
    with the annotation. weight: of a landmark against the shape of the surface (the paper's lambda). laplacian:
    "cotangent", or "uniform" as published. Jaw landmarks stand where the outline is. Mouth cavity and eye sockets stay
    behind the skin.
    Returns Refinement. Raises InputError when the landmarks are not of this picture or contradict each other.
    """
    note = template.annotation
    if len(points) not in (68, len(note.landmarks)):
        raise InputError(f"expected 68 or {len(note.landmarks)} landmarks, found {len(points)}")
    jaw = slide_contour(vertices, pose.rotation, template.vertices, note.landmarks[:JAW], note.jaw_paths)
    # Where paths meet two landmarks can slide to one vertex; then the second stays where it was marked.
    first = np.zeros(JAW, dtype=bool)
    first[np.unique(jaw, return_index=True)[1]] = True
    jaw = np.where(first, jaw, note.landmarks[:JAW])
    anchors = np.concatenate([jaw, note.landmarks[JAW : len(points)]])
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    diagonal = float(np.linalg.norm(np.ptp(points[known], axis=0)))
    before = _errors(pose.project(vertices[anchors]), points, diagonal)
    if before["all"] > 100 * FARTHEST:
        raise InputError(
            f"expected landmarks of the picture that the face was fitted to, found them {before['all']:.0f} % of their "
            "extent away on average"
        )
    _check_apart(points, diagonal)
    wanted = _meeting(points, pose, diagonal, pose.project(vertices[anchors]))
    ids, targets = _distinct(anchors[known], wanted[known], diagonal)
    places = pose.lift(targets, vertices[ids])

    def move(shape):
        return LaplacianDeformation(shape, template.faces, ids, weight, laplacian).move(places)

    moved = move(vertices)
    # What nothing pulls at stays as it is, flipped triangles and all.
    still = np.abs(moved - vertices).max() < STILL * template.height
    sound = moved if still else untangle(moved, template.gradients)
    if sound is not moved:
        moved = move(sound)
    if not still:
        moved = template.cavities.tuck(moved)
    return Refinement(
        vertices=moved,
        landmarks=pose.project(moved[anchors]),
        anchors=anchors,
        before=before,
        after=_errors(pose.project(moved[anchors]), points, diagonal),
        moved=float(np.linalg.norm(moved - vertices, axis=1).max()),
        flipped=float(flipped_triangles(moved, template.gradients).mean()),
    )


def _meeting(points, pose, diagonal, own):
    """Landmarks whose lids and lips that have passed each other meet half-way; far ones are refused.

    own: (L, 2) pixels, the face's: lids and lips that overlap as far there already stay as they are.
    """
    points, up = np.array(points), pose.rotation[:2, 1]
    up = up / (np.linalg.norm(up) * diagonal)
    for upper, lower in OPPOSITE:
        passed, before = (float((places[lower] - places[upper]) @ up) for places in (points, own))
        if abs(passed - before) < SAME:
            continue
        if passed > max(before, 0) + (LIPS_CROSSED if upper in PARTS["mouth"] else CROSSED):
            raise InputError(f"landmarks {upper} and {lower}: expected the upper above the lower, found them crossed")
        if passed > 0:
            points[[upper, lower]] = points[[upper, lower]].mean(0)
    return points


def _distinct(ids, targets, diagonal):
    """Anchors without repeats; one that two landmarks want in different places is refused."""
    kept, first, row = np.unique(ids, return_index=True, return_inverse=True)
    apart = np.linalg.norm(targets - targets[first][row], axis=1)
    if apart.max() > CROSSED * diagonal:
        worst = int(apart.argmax())
        found = f"vertex {ids[worst]} wanted in two, {apart[worst]:.0f} pixels apart"
        raise InputError(f"expected one place for every vertex, found {found}")
    return kept, targets[first]


def _check_apart(points, diagonal):
    """Refuse two landmarks in one place, but those that meet on a closed eye or mouth."""
    near = np.linalg.norm(points[:, None] - points, axis=-1) < SAME * diagonal
    for a, b in np.argwhere(np.triu(near, 1)).tolist():
        if (a, b) not in (*OPPOSITE, *CORNERS):
            raise InputError(f"expected landmarks in different places, found {a} and {b} in one")


def _errors(found, points, diagonal):
    """Mean distances in percent by part of the face, where landmarks are known."""
    distances = 100 * np.linalg.norm(found - points, axis=1) / diagonal
    parts = {name: distances[[k for k in ids if k < len(points)]] for name, ids in PARTS.items()} | {"all": distances}
    return {name: float(np.nanmean(d)) for name, d in parts.items() if np.isfinite(d).any()}
