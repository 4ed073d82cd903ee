"""How sound a rig is: contacts that close, triangles that stay upright, lids that clear the eyes."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.deformation_gradients import DeformationGradients
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.methods.rig.add_eyeballs import lid_vertices, moving_vertices
from caricli.methods.rig.expression_templates import start_delta


@dataclass(frozen=True, eq=False)
class RigMeasures:
    """flipped (K,), share of triangles turned over in every expression, on top of what it starts from; strength (K,),
    root mean square displacement, of that of the templates scaled to the face, nan where nothing moves; contact_gap
    (K,), mean distance of the pairs that come together, of what it was before, nan where none do; lid_gap, of a blink
    by side, of the open lids'; lip_gap, seen from the front, of mouthClose with jawOpen, of jawOpen alone, or None;
    lips_open, the same of the neutral face; inside, how deep lids are inside the eyeballs at most, in metres, negative
    for a distance, or None.
    """

    flipped: np.ndarray
    strength: np.ndarray
    contact_gap: np.ndarray
    lid_gap: dict
    lip_gap: float | None
    lips_open: float | None
    inside: float | None


def measure_rig(deltas, neutral, templates, annotation, scale, eyeballs=()):
    """Measure displacements of a face.

    deltas: (K, V, 3). neutral: (V, 3). templates: ExpressionTemplates they were transferred from. annotation:
    Annotation, or None for a mesh that nothing is known of. scale: size of the face against the templates.
    eyeballs: list of Eyeball. Returns RigMeasures.
    """
    gradients = DeformationGradients(neutral, templates.faces)
    place = {name: k for k, name in enumerate(templates.names)}
    starts = [neutral + start_delta(templates.names, deltas, k) for k in range(len(deltas))]
    flipped = [flipped_triangles(s + d, gradients).mean() for s, d in zip(starts, deltas, strict=True)]
    sizes, usual = (np.sqrt((d**2).sum(-1).mean(-1)) for d in (deltas, templates.deltas))
    moving = np.array([made is not None for made in templates.motions])
    strength = np.where(moving, sizes / np.where(moving, scale * usual, 1.0), np.nan)
    gaps = np.full(len(deltas), np.nan)
    for k, (start, delta) in enumerate(zip(starts, deltas, strict=True)):
        made = templates.motions[k]
        if made is not None and made.closed.any():
            pairs = templates.pairs[made.closed]
            then, now = (_lengths(v, pairs).mean() for v in (start, start + delta))
            gaps[k] = now / then
    known = {} if annotation is None else annotation.curves
    lids = {}
    for side in ("left", "right"):
        name, curves = f"eyeBlink{side.capitalize()}", (f"eye_upper_{side}", f"eye_lower_{side}")
        if name in place and all(curve in known for curve in curves):
            ids = [known[curve] for curve in curves]
            lids[side] = curve_gap(neutral + deltas[place[name]], *ids) / max(curve_gap(neutral, *ids), 1e-9)
    lips, lips_open, ids = None, None, [known.get(f"mouth_inner_{lip}") for lip in ("upper", "lower")]
    if "mouthClose" in place and "jawOpen" in place and all(i is not None for i in ids):
        start = starts[place["mouthClose"]]
        # Seen from the front: lips that lie on each other may do so at any depth.
        shut = start + deltas[place["mouthClose"]]
        lips, lips_open = (curve_gap(v[:, :2], *ids) / curve_gap(start[:, :2], *ids) for v in (shut, neutral))
    inside = None
    for ball in eyeballs:
        ids = lid_vertices(annotation, ball.side)
        depth = ball.radius - np.linalg.norm(moving_vertices(neutral, deltas, ids) - ball.centre, axis=1).min()
        inside = depth if inside is None else max(inside, depth)
    return RigMeasures(np.array(flipped), strength, gaps, lids, lips, lips_open, inside)


def curve_gap(vertices, upper, lower):
    """Mean distance of the inner points of one polyline from another, in the unit of the vertices.

    vertices: (V, 2 or 3). upper, lower: vertex ids, from corner to corner.
    """
    points, ends = vertices[upper[1:-1]], vertices[lower]
    along = np.diff(ends, axis=0)
    share = ((points[:, None] - ends[:-1]) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-18)
    nearest = ends[:-1] + np.clip(share, 0, 1)[..., None] * along
    return float(np.linalg.norm(points[:, None] - nearest, axis=-1).min(1).mean())


def _lengths(vertices, pairs):
    return np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)
