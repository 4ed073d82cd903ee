"""Move a few points of a face, the rest of it follows as faces do (deformable paper, section 5.3)."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.self_intersections import self_intersections
from caricli.geometry.untangle import untangle
from caricli.methods.faces.encode_face import EncodedFace, decode_face, encode_face

_CORRECTIONS = 2
_SPREAD, _ROUNDS = 100, 16
_BISECTIONS = 6
_ZERO = 0.05


@dataclass(frozen=True)
class HandleSettings:
    """Weights of the edit, in whitened latents and in ``tolerance``, a share of the head's height.

    norm: of the latent's change, 1 as in equation 4, or 2; preserve: its weight. keep: weight of the movement of points
    that are far from all handles; reach: how far they are then, a share of the head's height.
    """

    norm: int = 2
    tolerance: float = 0.002
    preserve: float = 0.01
    keep: float = 0.1
    reach: float = 0.25
    rounds: int = 15


@dataclass(frozen=True, eq=False)
class HandleEdit:
    """An edited face.

    face: EncodedFace. achieved: (H, 3) metres, how far the handles went. share: of the asked displacements that was
    tried, 1 unless new self-intersections had to be avoided. flipped: number of triangles that are, before and after.
    elsewhere: share of the movement's energy at vertices farther than ``reach`` from all handles.
    """

    face: EncodedFace
    achieved: np.ndarray
    share: float
    flipped: tuple
    elsewhere: float


def edit_handles(face, model, handles, displacements, settings=HandleSettings(), avoid=False):  # noqa: B008 (frozen)
    """Find the likeliest face whose handles are where they are asked to be.

    Minimises over the whitened latent z, in units of the tolerance,
    ``mean_h |p_h + d_h - v_h(z)|^2 + preserve |z - z0|_norm + keep mean_k w_k |v_k(z) - v_k(z0)|^2`` (equation 4, and
    the last term), k landmarks and points all over the head, w_k from 0 at handles to 1 far from them: without it, a
    latent of principal components moves the whole head. The first norm is not smooth; Gauss-Newton steps are reweighted
    for it. Handles are then corrected for what the residual, which stays on the face, does to them.

    face: EncodedFace of the model. model: ShapeModel. handles: (H,) vertex ids. displacements: (H, 3) metres, zero for
    what is to stay. settings: HandleSettings. avoid: go only as far as nothing new goes through the surface.
    Returns HandleEdit.
    """
    template, before = model.template, face.vertices
    solve = _Solve(face, model, handles, settings)
    share, solved = 1.0, solve(displacements)
    if avoid:
        crossing = self_intersections(before, template.faces)
        share, solved = _farthest(solve, displacements, solved, lambda v: _added(v, template.faces, crossing))
    vertices, latent, residual = solved
    moved = vertices - before
    energy = (moved**2).sum(1)
    flipped = tuple(int(flipped_triangles(v, template.gradients).sum()) for v in (before, vertices))
    elsewhere = float(energy[solve.far].sum() / max(energy.sum(), 1e-30))
    edited = encode_face(vertices, model, latent, residual)
    return HandleEdit(edited, moved[handles], share, flipped, elsewhere)


def _farthest(solve, displacements, whole, bad):
    """The largest share of the displacements, to 1/64, whose shape is not bad, and what it came to."""
    if not bad(whole[0]):
        return 1.0, whole
    low, high, best = 0.0, 1.0, solve(0 * displacements)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        trial = solve(middle * displacements)
        low, high, best = (low, middle, best) if bad(trial[0]) else (middle, high, trial)
    return low, best


class _Solve:
    """Displacements of the handles to a face."""

    def __init__(self, face, model, handles, settings):
        self.face, self.model, self.handles, self.settings = face, model, handles, settings
        template, reach = model.template, settings.reach * model.template.height
        distance, _ = cKDTree(template.vertices[handles]).query(template.vertices)
        self.far = distance > reach
        spread = np.arange(0, len(template.vertices), max(1, len(template.vertices) // _SPREAD))
        others = np.union1d(template.annotation.landmarks, spread)
        weights = 1 - np.exp(-((distance[others] / reach) ** 2))
        self.kept, self.weights = others[weights > 0.1], weights[weights > 0.1]
        self.points = np.concatenate([handles, self.kept])
        self.unit = settings.tolerance * template.height
        self.start = model.prior.whiten(face.latent)
        self.places = model.decode_points(face.latent, self.points)

    def __call__(self, displacements):
        """Returns vertices (V, 3), latent (D,), and the residual (V, 9) that goes with them."""
        if not displacements.any():
            return self.face.vertices, self.face.latent, self.face.residual
        model, face, asked, whitened = self.model, self.face, displacements, self.start
        gradients = model.template.gradients
        for _ in range(1 + _CORRECTIONS):
            whitened = self._latent(asked, whitened)
            latent = model.prior.colour(whitened)
            vertices = decode_face(latent, face.residual, model, face.shift)
            vertices = untangle(vertices, gradients, _ROUNDS, face.vertices)
            missing = displacements - (vertices - face.vertices)[self.handles]
            asked = asked + missing
        return vertices, latent, face.residual

    def _latent(self, displacements, whitened):
        settings, model, count = self.settings, self.model, len(self.handles)
        goal = self.places.copy()
        goal[:count] += displacements
        weights = np.concatenate([np.full(count, 1 / count), settings.keep * self.weights / max(len(self.kept), 1)])
        weights = np.repeat(weights, 3) / self.unit**2
        for _ in range(settings.rounds):
            positions, jacobian = model.points_jacobian(model.prior.colour(whitened), self.points)
            rows = (jacobian @ model.prior.factor).reshape(-1, len(whitened))
            change = whitened - self.start
            # |x| = x^2 / |x|: the reweighting of the first norm, rounded off near zero.
            pull = np.maximum(np.abs(change), _ZERO) ** (settings.norm - 2.0) * settings.preserve
            system = (rows.T * weights) @ rows + np.diag(pull)
            right = rows.T @ (weights * (goal - positions).ravel()) - pull * change
            step = np.linalg.solve(system, right)
            whitened = whitened + step
            if np.abs(step).max() < 1e-3:
                break
        return whitened


def _added(vertices, faces, before):
    """Whether triangles go through each other that did not before."""
    return not set(map(tuple, self_intersections(vertices, faces))) <= set(map(tuple, before))
