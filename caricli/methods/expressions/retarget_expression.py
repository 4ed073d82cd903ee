"""Weights of a rig's expressions that explain the expressions of normal faces (expressions paper, equation 19)."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.geometry.deformation_gradients import rotation_matrices
from caricli.geometry.similarity import similarity
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.reconstruct.fit_landmarks import LatentSettings
from caricli.structures import Camera

STRONGEST = 1.5
"""Upper bound of a weight."""

NOISE = 0.007
"""How far a vertex is expected from where its neighbours place it, as a share of the template's height."""

SPARSE, WEAK = 1.0, 1e-4
"""Prices of a weight and of half its square: few expressions at a time are likelier than many, where both explain."""

CAUTION, SPARSE_LANDMARKS = 2.0, 1.5
"""Of landmarks identity is twice as dear, and a weight by a half: more of a strong expression is found in them, 0.6
instead of 0.5, at the same error of the face."""

_ROUNDS, _SETTLED = 20, 1e-3


@dataclass(frozen=True, eq=False)
class Explanation:
    """What faces do: weights (T, K) of the expressions; neutral (N, 3) metres, the face that does it; errors (T,), what
    is left: millimetres from the vertices of meshes, percent of the diagonal from landmarks."""

    weights: np.ndarray
    neutral: np.ndarray
    errors: np.ndarray


@threadpool_limits.wrap(limits=1)
def explain_meshes(shapes, deltas, model, neutral=None):
    """Explain meshes by one identity, and an expression and a similarity transform for each.

    Minimises ``sum_t |H(v_t - n - sum_i a_i U_i - sum_k w_tk N_k)|^2 / noise^2 + |a|^2 + 2 sparse sum w + weak |w|^2``
    over the identity a, 0 <= w <= 1.5 and the similarities that v_t are seen through: equation 19 with the neutral face
    unknown. H takes what a vertex differs by from the mean of its neighbours: in that, identities, which vary smoothly,
    resemble expressions, which part lips and lids, less than in positions. Where the neutral face is known, it is n;
    there is neither a nor a price, and H takes off the mean of all vertices.

    shapes: (T, N, 3). deltas: (K, N, 3) metres, of the expressions on a normal face. model: MorphableModel. neutral:
    (N, 3) metres, of the same person, in the face frame, or None.
    Returns Explanation. Raises InputError where no expression moves anything.
    """
    template, shapes = model.template, np.asarray(shapes, float)
    mean, identity = model.mean, model.identity
    face = template.region("face")
    middle, price = vertex_neighbours(template.faces, len(mean))[1], SPARSE
    if neutral is not None:
        mean, identity = np.asarray(neutral, float), identity[:0]
        middle, price = np.full((1, len(mean)), 1 / len(mean)), 0.0
    noise, deltas = NOISE * template.height, _moving(deltas)

    def rows(fields):
        return np.array([(field - middle @ field).ravel() / noise for field in fields]).reshape(-1, mean.size)

    centred = mean - mean.mean(0)
    motions = np.stack([*(np.cross(axis, centred) for axis in np.eye(3)), centred])
    system = BoundedSystem(rows(motions), rows(identity), rows(deltas), price)
    shapes = [_moved(shape, shape[face], mean[face]) for shape in shapes]
    who = np.zeros(len(identity))
    for _ in range(_ROUNDS):
        reduced = [system.reduced(rows([shape - mean])[0]) for shape in shapes]
        (who, weights, steps), before = exchange(reduced, who), who
        shapes = [
            _moved(shape, shape, shape - np.tensordot(step, motions, 1))
            for shape, step in zip(shapes, steps, strict=True)
        ]
        if max(np.abs(steps).max(), np.abs(who - before).max(initial=0)) < _SETTLED:
            break
    neutral = mean + np.tensordot(who, identity, 1)
    left = (shape - neutral - np.tensordot(w, deltas, 1) for shape, w in zip(shapes, weights, strict=True))
    errors = [1000 * np.linalg.norm(gaps - gaps.mean(0), axis=1).mean() for gaps in left]
    return Explanation(weights, neutral, np.array(errors))


@threadpool_limits.wrap(limits=1)
def explain_landmarks(fits, points, deltas, model):
    """Explain landmarks by one identity, and an expression and a pose for each: equation 19 in the picture plane.

    Minimises ``sum_t |s_t R_t (n + sum_i a_i U_i + sum_k w_tk N_k) + x_t - q_t|^2 / noise^2 + |caution a|^2 + 2 sparse
    sum w + weak |w|^2`` over identity, 0 <= w <= 1.5 and poses, on the landmarks, distances in shares of their
    diagonal.

    fits: LandmarkFit of ``fit_morphable`` for each: where the poses start, and what the landmarks stand on. points: T
    arrays (L, 2) pixels, NaN where unknown. deltas: (K, N, 3) metres. model: MorphableModel.
    Returns Explanation. Raises InputError where no expression moves anything.
    """
    deltas = _moving(deltas)
    views = [_View(fit, marks) for fit, marks in zip(fits, points, strict=True)]
    identity = model.identity / CAUTION
    who = CAUTION * np.mean([model.parts(fit.latent)[0] for fit in fits], axis=0)
    weights = np.zeros((len(views), len(deltas)))
    for _ in range(_ROUNDS):
        reduced = []
        for view, w in zip(views, weights, strict=True):
            at = view.anchors
            now = model.mean[at] + np.tensordot(who, identity[:, at], 1) + np.tensordot(w, deltas[:, at], 1)
            reduced.append(view.reduced(now, model.mean[at], identity[:, at], deltas[:, at]))
        (who, weights, steps), before = exchange(reduced, who), who
        for view, step in zip(views, steps, strict=True):
            view.move(step)
        if max(np.abs(steps).max(), np.abs(who - before).max(initial=0)) < _SETTLED:
            break
    neutral = model.mean + np.tensordot(who, identity, 1)
    shapes = (neutral + np.tensordot(w, deltas, 1) for w in weights)
    return Explanation(weights, neutral, np.array([v.error(shape) for v, shape in zip(views, shapes, strict=True)]))


class _View:
    """The known landmarks of one picture, and the camera as it is found."""

    def __init__(self, fit, points):
        known = np.isfinite(points).all(axis=1)
        self.anchors, self.points = fit.anchors[known], points[known]
        self.pose, self.diagonal = fit.pose, float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def reduced(self, now, mean, identity, deltas):
        """The problem around a shape whose landmarks are at (L, 3)."""
        unit = self.diagonal * LatentSettings.noise
        x, y, z = self.pose.scale / unit * (now @ self.pose.rotation.T).T
        none, one = np.zeros_like(x), np.ones_like(x)
        motions = [(none, -z), (z, none), (-y, x), (x, y), (one, none), (none, one)]
        motions = np.array(motions).transpose(0, 2, 1).reshape(6, -1)
        seen = self.pose.scale / unit * self.pose.rotation[:2].T
        parts = ((fields @ seen).reshape(len(fields), -1) for fields in (identity, deltas))
        right = (self.points - self.pose.project(mean)) / unit
        return BoundedSystem(motions, *parts, SPARSE_LANDMARKS).reduced(right.ravel())

    def move(self, step):
        """Turn the camera, log its scale and shift it."""
        rotation = rotation_matrices(step[None, :3])[0] @ self.pose.rotation
        shift = self.diagonal * LatentSettings.noise * step[4:]
        self.pose = Camera(self.pose.scale * float(np.exp(step[3])), rotation, self.pose.translation + shift)

    def error(self, vertices):
        """Mean distance from the landmarks in percent of their diagonal."""
        gaps = self.pose.project(vertices[self.anchors]) - self.points
        return 100 * np.linalg.norm(gaps, axis=1).mean() / self.diagonal


class BoundedSystem:
    """Least squares ``|p motions + a identity + w deltas - right|^2 + weak |w|^2 + 2 price sum w``, factored once for
    every right side; only w is bounded.

    motions (M, R), identity (I, R), deltas (K, R): rows. price: not negative.
    """

    def __init__(self, motions, identity, deltas, price):
        rows = np.concatenate([motions, identity, deltas])
        weak = np.zeros((len(rows), len(deltas)))
        weak[len(motions) + len(identity) :] = WEAK**0.5 * np.eye(len(deltas))
        basis, upper = np.linalg.qr(np.concatenate([rows, weak], axis=1).T)
        # The first rows of the triangle are the motions' own: what is below them no motion can do.
        self._count, parts = len(motions), [len(motions), len(motions) + len(identity)]
        self._motions, *self._couplings = np.split(upper[: len(motions)], parts, axis=1)
        _, self.identity, self.deltas = np.split(upper[len(motions) :], parts, axis=1)
        self._basis = basis[: rows.shape[1]]
        self._rotation, self._root = np.linalg.qr(self.deltas)
        self._toll = np.linalg.solve(self._root.T, np.full(len(deltas), price))

    def reduced(self, right):
        """The Frame of a right side (R,)."""
        own, rest = np.split(right @ self._basis, [self._count])
        return Frame(self, own, rest)

    def weights(self, rest):
        """The best w (K,) for rows of the triangle below the motions."""
        wanted = rest @ self._rotation - self._toll
        found = lsq_linear(self._root, wanted, (0, STRONGEST), "bvls", max_iter=10 * len(wanted)).x
        return np.clip(found, 0, STRONGEST)  # rounding

    def motion(self, own, who, weights):
        """The best p (M,) for the motions' own rows, a and w."""
        identity, deltas = self._couplings
        return np.linalg.solve(self._motions, own - identity @ who - deltas @ weights)


@dataclass(frozen=True, eq=False)
class Frame:
    """A BoundedSystem with the right side of one face: own (M,) and rest, the rows of the triangle."""

    system: BoundedSystem
    own: np.ndarray
    rest: np.ndarray


def exchange(frames, who):
    """One step towards the least of ``|a|^2`` and the sums of all Frames, which share a: w for a, a for w, and p.

    Repeated, it finds the least; solving for all at once brings weights back no better, and not sooner.

    frames: T of them. who: (I,) the a to start from. Returns a (I,), w (T, K), p (T, M).
    """
    weights = np.array([frame.system.weights(frame.rest - frame.system.identity @ who) for frame in frames])
    square, right = np.eye(len(who)), np.zeros(len(who))
    for frame, w in zip(frames, weights, strict=True):
        identity = frame.system.identity
        square += identity.T @ identity
        right += identity.T @ (frame.rest - frame.system.deltas @ w)
    who = np.linalg.solve(square, right)
    motions = [frame.system.motion(frame.own, who, w) for frame, w in zip(frames, weights, strict=True)]
    return who, weights, np.array(motions)


def _moved(vertices, source, target):
    """Vertices (V, 3) by the similarity that takes source to target."""
    scale, rotation, translation = similarity(source, target)
    return scale * vertices @ rotation.T + translation


def _moving(deltas):
    """Displacements in double precision, refused where there are none."""
    deltas = np.asarray(deltas, float)
    if not deltas.any():
        raise InputError("expected expressions that move a normal face, found none that does")
    return deltas
