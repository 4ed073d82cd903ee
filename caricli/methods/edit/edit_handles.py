"""Move a few points of a face, the rest of it follows as faces do (deformable paper, section 5.3)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from caricli.geometry.gauss_newton import gauss_newton
from caricli.geometry.repair.components import component_labels
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.self_intersections import self_intersections
from caricli.geometry.repair.untangle import untangle
from caricli.methods.edit.handle_points import Handles
from caricli.methods.faces.encode_face import EncodedFace, decode_face, encode_face, require_encoded
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face


@dataclass(frozen=True)
class HandleSettings:
    """What an edit is tuned by; terms are weighed in whitened latents and in ``tolerance``.

    norm: of the latent's change, 1 as in equation 4, or 2, which moves all of the latent a little and folds less.
    tolerance: share of the template's height, how near to its goal a handle is near enough.
    preserve: weight of the latent's change: small, so that handles reach their goals.
    keep: weight of the movement of points that are far from all handles: without it the whole head goes along.
    reach: share of the template's height, how far they are then: about a nose's length.
    least: weight (0 to 1) below which a point is too near to a handle to be kept.
    spread: points all over the head that are kept, besides landmarks: enough that no part is free to go.
    rounds: Gauss-Newton steps at most.
    settled: largest entry of a step, in whitened latents, that moves nothing that is seen.
    smallest: change of a latent's entry, in standard deviations, below which the first norm is rounded off.
    corrections: times that handles are asked for what they missed.
    untangling: rounds of turning flipped triangles back, few because the face before is near.
    bisections: of the way to the first self-intersection: to 1/64 of it.
    """

    norm: int = 2
    tolerance: float = 0.002
    preserve: float = 0.01
    keep: float = 0.1
    reach: float = 0.25
    least: float = 0.1
    spread: int = 100
    rounds: int = 15
    settled: float = 1e-3
    smallest: float = 0.05
    corrections: int = 2
    untangling: int = 16
    bisections: int = 6


@dataclass(frozen=True, eq=False)
class HandleEdit:
    """An edited face.

    face: EncodedFace.
    handles: Handles as they were asked for. settings: what it was tuned by.
    achieved: (H, 3) metres, how far the handles went.
    share: of the asked displacements that was tried, 1 unless new self-intersections had to be avoided.
    flipped: number of triangles that are, before and after.
    elsewhere: share of the movement's energy at vertices farther than ``reach`` from all handles.
    """

    face: EncodedFace
    handles: Handles
    settings: HandleSettings
    achieved: np.ndarray
    share: float
    flipped: tuple[int, int]
    elsewhere: float

    @property
    def tried(self) -> Handles:
        """As far as they were pulled."""
        return self.handles.scaled(self.share)

    @property
    def reached(self) -> np.ndarray:
        """(H,) share of every displacement that was reached, along it; nan for what was to stay."""
        asked = self.handles.displacements
        squares = (asked**2).sum(1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(squares > 0, (self.achieved * asked).sum(1) / squares, np.nan)


def edit_handles(
    face: EncodedFace,
    model: ShapeModel,
    handles: Handles,
    settings: HandleSettings = HandleSettings(),  # noqa: B008 (frozen)
    avoid: bool = False,
) -> HandleEdit:
    """Find the likeliest face whose handles are where they are asked to be.

    Minimises over the whitened latent z, in units of the tolerance,
    ``mean_h |p_h + d_h - v_h(z)|^2 + preserve |z - z0|_norm + keep mean_k w_k |v_k(z) - v_k(z0)|^2`` (equation 4, and
    the last term), k landmarks and points all over the head, w_k from 0 at handles to 1 far from them: without it, a
    latent of principal components moves the whole head. The first norm is not smooth; Gauss-Newton steps are reweighted
    for it. Handles are then corrected for what the residual, which stays on the face, does to them.

    face: EncodedFace of the model. model: ShapeModel. handles: Handles of its mesh. settings: HandleSettings.
    avoid: go only as far as nothing goes through the surface where nothing did before, or next to it.
    Returns HandleEdit. Raises InputError for a face of another model.
    """
    require_encoded(face, model)
    gradients = model.template.gradients
    solver = _Solver(face, model, handles, settings)
    share = 1.0
    edited = solver.solve(handles.displacements)
    if avoid:
        around = _around(face, _crossing(face))
        share, edited = _farthest(solver, handles, edited, lambda trial: not around[_crossing(trial)].all())
    moved = edited.vertices - face.vertices
    energy = (moved**2).sum(1)
    before, after = (int(flipped_triangles(each.vertices, gradients).sum()) for each in (face, edited))
    return HandleEdit(
        face=encode_face(edited, model),
        handles=handles,
        settings=settings,
        achieved=moved[handles.vertices],
        share=share,
        flipped=(before, after),
        elsewhere=float(energy[solver.far].sum() / max(energy.sum(), 1e-30)),
    )


def _farthest(solver: "_Solver", handles: Handles, whole: Face, bad: Callable[[Face], bool]) -> tuple[float, Face]:
    """The largest share of the displacements whose face is not bad, and this face; whole: that of all of them."""
    if not bad(whole):
        return 1.0, whole
    low = 0.0
    high = 1.0
    best = solver.solve(0 * handles.displacements)
    for _ in range(solver.settings.bisections):
        middle = (low + high) / 2
        trial = solver.solve(middle * handles.displacements)
        if bad(trial):
            high = middle
        else:
            low = middle
            best = trial
    return low, best


def _crossing(face: Face) -> np.ndarray:
    """Numbers of triangles that go through others of the same surface; lashes stand in lids, and slide there."""
    pairs = self_intersections(face.vertices, face.faces)
    surface = component_labels(face.faces, len(face.vertices))[face.faces[:, 0]]
    return np.unique(pairs[surface[pairs[:, 0]] == surface[pairs[:, 1]]])


def _around(face: Face, triangles: np.ndarray) -> np.ndarray:
    """(F,) bool, those triangles and their neighbours."""
    return np.asarray(np.isin(face.faces, face.faces[triangles]).any(1))


class _Solver:
    """Displacements of the handles to a face; ``far`` are the vertices (V,) beyond the reach of all handles."""

    def __init__(self, face: EncodedFace, model: ShapeModel, handles: Handles, settings: HandleSettings) -> None:
        self.face = face
        self.model = model
        self.handles = handles.vertices
        self.settings = settings
        template = model.template
        reach = settings.reach * template.height
        distance, _ = KDTree(template.vertices[self.handles]).query(template.vertices)
        self.far = distance > reach
        stride = max(1, len(template.vertices) // settings.spread)
        # Evenly from back to front, because nothing may hang on how vertices are numbered.
        order = np.lexsort(template.vertices.T)
        others = np.union1d(template.annotation.landmarks, order[stride // 2 :: stride])
        weights = 1 - np.exp(-((distance[others] / reach) ** 2))
        kept = weights > settings.least
        self.points = np.concatenate([self.handles, others[kept]])
        self.weights = self._point_weights(weights[kept])
        self.start = model.prior.whiten(face.latent)
        self.places = model.decode_points(face.latent, self.points)

    def _point_weights(self, kept: np.ndarray) -> np.ndarray:
        """(3K,) weights of the coordinates of all points, from those of the kept ones."""
        count = len(self.handles)
        unit = self.settings.tolerance * self.model.template.height
        weights = np.concatenate([np.full(count, 1 / count), self.settings.keep * kept / max(len(kept), 1)])
        return np.repeat(weights, 3) / unit**2

    def solve(self, displacements: np.ndarray) -> Face:
        """The face whose handles went by displacements (H, 3)."""
        if not displacements.any():
            return self.face
        asked = displacements
        whitened = self.start
        least = np.inf
        for _ in range(1 + self.settings.corrections):
            whitened = self._latent(asked, whitened)
            edited = self._decoded(whitened)
            missing = displacements - (edited.vertices - self.face.vertices)[self.handles]
            # Asked for more, a face can turn over more triangles and, once these are turned back, reach less.
            if np.linalg.norm(missing) < least:
                least = float(np.linalg.norm(missing))
                best = edited
            asked = asked + missing
        return best

    def _decoded(self, whitened: np.ndarray) -> Face:
        """The face of a whitened latent (D,), without triangles that the edit turned over, and with cavities inside."""
        latent = self.model.prior.colour(whitened)
        decoded = decode_face(replace(self.face, latent=latent), self.model, self.face.shift)
        template = self.model.template
        vertices = untangle(decoded.vertices, template.gradients, self.settings.untangling, self.face.vertices)
        return decoded.with_vertices(template.cavities.tuck(vertices))

    def _latent(self, displacements: np.ndarray, whitened: np.ndarray) -> np.ndarray:
        """The whitened latent (D,) that takes the handles nearest to their goals, sought from another one."""
        goal = self.places.copy()
        goal[: len(self.handles)] += displacements
        return gauss_newton(
            whitened, lambda z: self._normal_equations(z, goal), self.settings.rounds, self.settings.settled
        )

    def _normal_equations(self, whitened: np.ndarray, goal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """System (D, D) and right side (D,) at a whitened latent (D,) for goals (K, 3)."""
        settings = self.settings
        positions, jacobian = self.model.points_jacobian(self.model.prior.colour(whitened), self.points)
        rows = (jacobian @ self.model.prior.factor).reshape(-1, len(whitened))
        change = whitened - self.start
        # |x| = x^2 / |x|: the reweighting of the first norm, rounded off near zero.
        pull = np.maximum(np.abs(change), settings.smallest) ** (settings.norm - 2.0) * settings.preserve
        system = (rows.T * self.weights) @ rows + np.diag(pull)
        return system, rows.T @ (self.weights * (goal - positions).ravel()) - pull * change
