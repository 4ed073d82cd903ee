"""Weights of a rig's expressions that explain the expressions of normal faces (expressions paper, equation 19)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.settings import LatentSettings
from caricli.models.morphable.model import MorphableModel
from caricli.structures import Camera
from caricli.structures.track import MOST

_SHARED = 1e-6
"""Weight of the weaker of two opposites, at most: bounds of the solver must differ."""


@dataclass(frozen=True)
class RetargetSettings:
    """What is likely of faces and expressions.

    strongest: upper bound of a weight.
    noise: share of the template's height; how far a vertex is expected from where its neighbours place it.
    sparse: price of a weight: few expressions at a time are likelier than many, where both explain.
    weak: price of half the square of a weight, which makes the weights unique.
    caution: factor of identity in its price, before it is squared, where there are landmarks alone: below one, as faces
    are more than the few that the model was trained with, and landmarks tell little enough of them.
    rounds: exchanges between identity and weights at most.
    settled: largest step, in the units of motions and identity, that ends them.
    opposites: pairs of numbers of expressions, of which a face does one at most.
    """

    strongest: float = MOST
    noise: float = 0.007
    sparse: float = 1.0
    weak: float = 1e-4
    caution: float = 0.4
    rounds: int = 20
    settled: float = 1e-3
    opposites: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, eq=False)
class Explanation:
    """What faces do.

    weights: (T, K) of the expressions.
    neutral: (N, 3) metres, the face that does it.
    errors: (T,) what is left: millimetres from the vertices of meshes, percent of the diagonal from landmarks.
    """

    weights: np.ndarray
    neutral: np.ndarray
    errors: np.ndarray


@threadpool_limits.wrap(limits=1)
def explain_meshes(
    shapes: Sequence[np.ndarray],
    deltas: np.ndarray,
    model: MorphableModel,
    neutral: np.ndarray | None = None,
    settings: RetargetSettings = RetargetSettings(),  # noqa: B008 (frozen)
) -> Explanation:
    """Explain meshes by one identity, and an expression and a similarity transform for each.

    Minimises ``sum_t |H(v_t - n - sum_i a_i U_i - sum_k w_tk N_k)|^2 / noise^2 + |a|^2 + 2 sparse sum w + weak |w|^2``
    over identity a, 0 <= w <= strongest and the similarities that v_t are seen through: equation 19, its neutral face
    unknown. H takes what a vertex differs by from the mean of its neighbours: in that, identities, which vary smoothly,
    resemble expressions, which part lips and lids, less than in positions. Where the neutral face is known, it is n;
    there is neither a nor a price, and H takes off the mean of all vertices.

    shapes: T of (N, 3). deltas: (K, N, 3) metres, of the expressions on a normal face. neutral: (N, 3) metres, of the
    same person, in the face frame, or None.
    Raises InputError where no expression moves anything.
    """
    deltas = _check_moving(deltas)
    space = _MeshSpace(deltas, model, neutral, settings)
    face = model.template.region("face")
    faces = [_by_similarity(shape, shape[face], space.mean[face]) for shape in np.asarray(shapes, float)]
    who = np.zeros(len(space.identity))
    for _ in range(settings.rounds):
        before = who
        who, weights, steps = exchange([space.equations(shape) for shape in faces], who)
        faces = [space.move(shape, step) for shape, step in zip(faces, steps, strict=True)]
        if max(np.abs(steps).max(), np.abs(who - before).max(initial=0)) < settings.settled:
            break
    own = space.mean + np.tensordot(who, space.identity, 1)
    left = (shape - own - np.tensordot(w, deltas, 1) for shape, w in zip(faces, weights, strict=True))
    errors = [1000 * np.linalg.norm(gaps - gaps.mean(0), axis=1).mean() for gaps in left]
    return Explanation(weights, own, np.array(errors))


class _MeshSpace:
    """What a mesh can be: a mean face, motions, identities and expressions, in what vertices differ by from others."""

    def __init__(
        self, deltas: np.ndarray, model: MorphableModel, neutral: np.ndarray | None, settings: RetargetSettings
    ) -> None:
        template = model.template
        self.mean = model.mean
        self.identity = model.identity
        self._middle = vertex_neighbours(template.faces, len(self.mean))[1]
        price = settings.sparse
        if neutral is not None:
            self.mean = np.asarray(neutral, float)
            self.identity = model.identity[:0]
            self._middle = np.full((1, len(self.mean)), 1 / len(self.mean))
            price = 0.0
        self._noise = settings.noise * template.height
        centred = self.mean - self.mean.mean(0)
        self._motions = np.stack([*(np.cross(axis, centred) for axis in np.eye(3)), centred])
        motions, identity, expressions = (self._rows(fields) for fields in (self._motions, self.identity, deltas))
        self._system = BoundedSystem(motions, identity, expressions, price, settings)

    def _rows(self, fields: Iterable[np.ndarray]) -> np.ndarray:
        rows = [(field - self._middle @ field).ravel() / self._noise for field in fields]
        return np.array(rows).reshape(-1, self.mean.size)

    def equations(self, shape: np.ndarray) -> "FaceEquations":
        """Of a face (N, 3)."""
        return self._system.reduced(self._rows([shape - self.mean])[0])

    def move(self, shape: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The face (N, 3) without a motion: turns about three axes and a growth."""
        return _by_similarity(shape, shape, shape - np.tensordot(step, self._motions, 1))


@threadpool_limits.wrap(limits=1)
def explain_landmarks(
    fits: Sequence[LandmarkFit],
    points: Sequence[np.ndarray],
    deltas: np.ndarray,
    model: MorphableModel,
    settings: RetargetSettings = RetargetSettings(),  # noqa: B008 (frozen)
) -> Explanation:
    """Explain landmarks by one identity, and an expression and a camera for each: equation 19 in the picture plane.

    Minimises ``sum_t |s_t R_t (n + sum_i a_i U_i + sum_k w_tk N_k) + x_t - q_t|^2 / noise^2 + |caution a|^2 + 2 sparse
    sum w + weak |w|^2`` over identity, 0 <= w <= strongest and cameras, on the landmarks, distances in shares of their
    diagonal.

    fits: LandmarkFit of ``fit_morphable`` for each: where the cameras start, and what the landmarks stand on. points: T
    arrays (L, 2) pixels, NaN where unknown. deltas: (K, N, 3) metres.
    Raises InputError where no expression moves anything.
    """
    deltas = _check_moving(deltas)
    views = [_View(fit, marks) for fit, marks in zip(fits, points, strict=True)]
    identity = model.identity / settings.caution
    who = settings.caution * np.mean([model.parts(fit.face.require_latent())[0] for fit in fits], axis=0)
    weights = np.zeros((len(views), len(deltas)))
    for _ in range(settings.rounds):
        before = who
        equations = [
            view.equations(_Linear(model.mean, identity, deltas, view.anchors), who, w, settings)
            for view, w in zip(views, weights, strict=True)
        ]
        who, weights, steps = exchange(equations, who)
        for view, step in zip(views, steps, strict=True):
            view.move(step)
        if max(np.abs(steps).max(), np.abs(who - before).max(initial=0)) < settings.settled:
            break
    neutral = model.mean + np.tensordot(who, identity, 1)
    shapes = (neutral + np.tensordot(w, deltas, 1) for w in weights)
    return Explanation(weights, neutral, np.array([v.error(shape) for v, shape in zip(views, shapes, strict=True)]))


class _Linear:
    """Where the vertices that landmarks stand on can be: mean (L, 3), identities (I, L, 3), expressions (K, L, 3)."""

    def __init__(self, mean: np.ndarray, identity: np.ndarray, deltas: np.ndarray, anchors: np.ndarray) -> None:
        self.mean = mean[anchors]
        self.identity = identity[:, anchors]
        self.deltas = deltas[:, anchors]

    def points(self, who: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(L, 3) of an identity and weights."""
        return self.mean + np.tensordot(who, self.identity, 1) + np.tensordot(weights, self.deltas, 1)


class _View:
    """The landmarks of one picture that are known, and its camera as far as it is found."""

    def __init__(self, fit: LandmarkFit, points: np.ndarray) -> None:
        given = np.isfinite(points).all(axis=1)
        self.anchors = fit.anchors[given]
        self.points = points[given]
        self.camera = fit.face.require_camera()
        self.diagonal = float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def equations(
        self, space: _Linear, who: np.ndarray, weights: np.ndarray, settings: RetargetSettings
    ) -> "FaceEquations":
        """The problem around an identity (I,) and weights (K,)."""
        unit = self.diagonal * LatentSettings.noise
        x, y, z = self.camera.scale / unit * (space.points(who, weights) @ self.camera.rotation.T).T
        none = np.zeros_like(x)
        one = np.ones_like(x)
        motions = [(none, -z), (z, none), (-y, x), (x, y), (one, none), (none, one)]
        seen = self.camera.scale / unit * self.camera.rotation[:2].T
        identity, deltas = ((fields @ seen).reshape(len(fields), -1) for fields in (space.identity, space.deltas))
        right = (self.points - self.camera.project(space.mean)) / unit
        rows = np.array(motions).transpose(0, 2, 1).reshape(6, -1)
        return BoundedSystem(rows, identity, deltas, settings.sparse, settings).reduced(right.ravel())

    def move(self, step: np.ndarray) -> None:
        """Turn the camera, log its scale and shift it."""
        rotation = rotation_matrices(step[None, :3])[0] @ self.camera.rotation
        shift = self.diagonal * LatentSettings.noise * step[4:]
        self.camera = Camera(self.camera.scale * float(np.exp(step[3])), rotation, self.camera.translation + shift)

    def error(self, vertices: np.ndarray) -> float:
        """Mean distance from the landmarks in percent of their diagonal."""
        gaps = self.camera.project(vertices[self.anchors]) - self.points
        return 100 * np.linalg.norm(gaps, axis=1).mean() / self.diagonal


class BoundedSystem:
    """Least squares ``|p motions + a identity + w deltas - right|^2 + weak |w|^2 + 2 price sum w``, factored once for
    every right side; only w is bounded.
    """

    def __init__(
        self,
        motions: np.ndarray,
        identity: np.ndarray,
        deltas: np.ndarray,
        price: float,
        settings: RetargetSettings = RetargetSettings(),  # noqa: B008 (frozen)
    ) -> None:
        """motions (M, R), identity (I, R), deltas (K, R): rows. price: not negative."""
        rows = np.concatenate([motions, identity, deltas])
        weak = np.zeros((len(rows), len(deltas)))
        weak[len(motions) + len(identity) :] = settings.weak**0.5 * np.eye(len(deltas))
        basis, upper = np.linalg.qr(np.concatenate([rows, weak], axis=1).T)
        # The first rows of the triangle are the motions' own: what is below them no motion can do.
        self._count = len(motions)
        parts = [len(motions), len(motions) + len(identity)]
        self._motions, *self._couplings = np.split(upper[: len(motions)], parts, axis=1)
        _, self.identity, self.deltas = np.split(upper[len(motions) :], parts, axis=1)
        self._basis = basis[: rows.shape[1]]
        self._strongest = settings.strongest
        self._opposites = np.array(settings.opposites, int).reshape(-1, 2)
        self._rotation, self._root = np.linalg.qr(self.deltas)
        self._toll = np.linalg.solve(self._root.T, np.full(len(deltas), price))

    def reduced(self, right: np.ndarray) -> "FaceEquations":
        """The equations of a right side (R,)."""
        own, rest = np.split(right @ self._basis, [self._count])
        return FaceEquations(self, own, rest)

    def weights(self, rest: np.ndarray) -> np.ndarray:
        """The best w (K,) for rows of the triangle below the motions."""
        wanted = rest @ self._rotation - self._toll
        most = np.full(len(wanted), self._strongest)
        weights = self._within(wanted, most)
        both = self._opposites[weights[self._opposites].min(1) > _SHARED]
        if not len(both):
            return weights
        most[both[np.arange(len(both)), weights[both].argmin(1)]] = _SHARED
        return self._within(wanted, most)

    def _within(self, wanted: np.ndarray, most: np.ndarray) -> np.ndarray:
        """The best w (K,) between 0 and bounds (K,)."""
        solution = lsq_linear(self._root, wanted, (0, most), "bvls", max_iter=10 * len(wanted)).x
        return np.clip(solution, 0, most)  # rounding

    def motion(self, own: np.ndarray, who: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The best p (M,) for the motions' own rows, a and w."""
        identity, deltas = self._couplings
        return np.linalg.solve(self._motions, own - identity @ who - deltas @ weights)


@dataclass(frozen=True, eq=False)
class FaceEquations:
    """A BoundedSystem with the right side of one face.

    own, rest: (M,) and (I + K,), of the rows of the triangle that are the motions', and of those below.
    """

    system: BoundedSystem
    own: np.ndarray
    rest: np.ndarray


def exchange(equations: Sequence[FaceEquations], who: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step towards the least of ``|a|^2`` and the sums of all faces, which share a: w for a, a for w, and p.

    Repeated, it finds the least; solving for all at once brings weights back no better, and not sooner.

    equations: T of them. who: (I,) the a to start from. Returns a (I,), w (T, K), p (T, M).
    """
    weights = np.array([face.system.weights(face.rest - face.system.identity @ who) for face in equations])
    square = np.eye(len(who))
    right = np.zeros(len(who))
    for face, w in zip(equations, weights, strict=True):
        identity = face.system.identity
        square += identity.T @ identity
        right += identity.T @ (face.rest - face.system.deltas @ w)
    who = np.linalg.solve(square, right)
    motions = [face.system.motion(face.own, who, w) for face, w in zip(equations, weights, strict=True)]
    return who, weights, np.array(motions)


def _by_similarity(vertices: np.ndarray, source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Vertices (V, 3) by the similarity that takes source to target."""
    scale, rotation, translation = similarity(source, target)
    return scale * vertices @ rotation.T + translation


def _check_moving(deltas: np.ndarray) -> np.ndarray:
    """Displacements in double precision, refused where there are none."""
    deltas = np.asarray(deltas, float)
    if not deltas.any():
        raise InputError("expected expressions that move a normal face, found none that does")
    return deltas
