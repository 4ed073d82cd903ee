"""How sound a rig is: contacts that close, triangles that stay upright, lids that clear the eyes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.rig.add_eyeballs import Eyeball, lid_vertices, moving_vertices
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.structures.arkit import start_delta

_OPEN = 1e-9
"""Least gap of what is open, metres, so that those that were shut before give a large share or none, and no
division by zero."""


@dataclass(frozen=True, eq=False)
class RigMeasures:
    """What was measured of K expressions.

    flipped: (K,) share of triangles turned over in every expression, on top of what it starts from.
    strength: (K,) root mean square displacement, of that of the templates scaled to the face; nan where nothing moves.
    contact_gap: (K,) mean distance of the pairs that come together, of what it was before; nan where none do.
    lid_gap: of a blink by side, of the open lids'.
    lip_gap: seen from the front, of mouthClose with jawOpen, of jawOpen alone; or None.
    lips_open: the same of the neutral face; or None.
    inside: metres, how deep lids are inside the eyeballs at most, negative for a distance; or None.
    """

    flipped: np.ndarray
    strength: np.ndarray
    contact_gap: np.ndarray
    lid_gap: dict[str, float]
    lip_gap: float | None
    lips_open: float | None
    inside: float | None


def measure_rig(
    neutral: np.ndarray, deltas: np.ndarray, templates: ExpressionTemplates, eyeballs: Sequence[Eyeball] = ()
) -> RigMeasures:
    """Measure displacements of a face.

    neutral: (V, 3) metres, of the templates' topology. deltas: (K, V, 3) metres. templates: what they were transferred
    from; lids, lips and eyes are measured where these know them by name. eyeballs: of the face.
    """
    motion = _Expressions(neutral, deltas, templates)
    lip_gap, lips_open = motion.lip_gaps()
    return RigMeasures(
        flipped=motion.flipped(),
        strength=motion.strength(),
        contact_gap=motion.contact_gap(),
        lid_gap=motion.lid_gaps(),
        lip_gap=lip_gap,
        lips_open=lips_open,
        inside=motion.depth(eyeballs),
    )


class _Expressions:
    """A neutral face (V, 3) and what the expressions of templates do to it, (K, V, 3)."""

    def __init__(self, neutral: np.ndarray, deltas: np.ndarray, templates: ExpressionTemplates) -> None:
        self.neutral = neutral
        self.deltas = deltas
        self.templates = templates
        self.starts = [neutral + start_delta(templates.names, deltas, k) for k in range(len(deltas))]
        self.curves = {} if templates.annotation is None else templates.annotation.curves

    def flipped(self) -> np.ndarray:
        faces = self.templates.faces
        gradients = DeformationGradients(self.neutral, faces)
        shares = []
        for start, delta in zip(self.starts, self.deltas, strict=True):
            near = (start + delta != self.neutral).any(1)
            near[faces[near[faces].any(1)]] = True
            # No others can have turned over: their surroundings are what they were.
            shares.append(flipped_triangles(start + delta, gradients, near[faces].any(1)).sum() / len(faces))
        return np.array(shares)

    def strength(self) -> np.ndarray:
        scale, *_ = similarity(self.templates.neutral, self.neutral)
        sizes, usual = (np.sqrt((d**2).sum(-1).mean(-1)) for d in (self.deltas, self.templates.deltas))
        moving = np.array([motion is not None for motion in self.templates.motions]) & (usual > 0)
        return np.where(moving, sizes / np.where(moving, scale * usual, 1.0), np.nan)

    def contact_gap(self) -> np.ndarray:
        gaps = np.full(len(self.deltas), np.nan)
        for k, motion in enumerate(self.templates.motions):
            if motion is not None and motion.closed.any():
                pairs = self.templates.pairs[motion.closed]
                before = _lengths(self.starts[k], pairs).mean()
                gaps[k] = _lengths(self.starts[k] + self.deltas[k], pairs).mean() / max(before, _OPEN)
        return gaps

    def lid_gaps(self) -> dict[str, float]:
        gaps = {}
        for side in ("left", "right"):
            name = f"eyeBlink{side.capitalize()}"
            lids = self._polylines(f"eye_upper_{side}", f"eye_lower_{side}")
            if name in self.templates.names and lids:
                shut = self.neutral + self.deltas[self.templates.names.index(name)]
                gaps[side] = curve_gap(shut, *lids) / max(curve_gap(self.neutral, *lids), _OPEN)
        return gaps

    def lip_gaps(self) -> tuple[float | None, float | None]:
        """Of mouthClose with jawOpen and of the neutral face, seen from the front: lips may meet at any depth."""
        names = self.templates.names
        lips = self._polylines("mouth_inner_upper", "mouth_inner_lower")
        if "mouthClose" not in names or "jawOpen" not in names or not lips:
            return None, None
        k = names.index("mouthClose")
        start = self.starts[k]
        shut, resting, jaw = (curve_gap(v[:, :2], *lips) for v in (start + self.deltas[k], self.neutral, start))
        return shut / max(jaw, _OPEN), resting / max(jaw, _OPEN)

    def _polylines(self, upper: str, lower: str) -> tuple[np.ndarray, np.ndarray] | None:
        """Vertex ids of two curves, or None where the mesh does not know both, or one is no more than its corners."""
        none = np.zeros(0, int)
        lines = self.curves.get(upper, none), self.curves.get(lower, none)
        return lines if min(map(len, lines)) > 2 else None

    def depth(self, eyeballs: Sequence[Eyeball]) -> float | None:
        annotation = self.templates.annotation
        if annotation is None:
            return None
        depths = []
        for ball in eyeballs:
            ids = lid_vertices(annotation, ball.side)
            away = moving_vertices(self.neutral, self.deltas, ids) - ball.centre
            depths.append(ball.radius - np.linalg.norm(away, axis=1).min())
        return max(depths, default=None)


def curve_gap(vertices: np.ndarray, upper: np.ndarray, lower: np.ndarray) -> float:
    """Mean distance of the inner points of one polyline from another, in the unit of the vertices.

    vertices: (V, 2 or 3). upper, lower: vertex ids, from corner to corner.
    """
    points = vertices[upper[1:-1]]
    ends = vertices[lower]
    along = np.diff(ends, axis=0)
    share = ((points[:, None] - ends[:-1]) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-18)
    nearest = ends[:-1] + np.clip(share, 0, 1)[..., None] * along
    return float(np.linalg.norm(points[:, None] - nearest, axis=-1).min(1).mean())


def _lengths(vertices: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)
