"""A 3D face from 2D landmarks: elastically (intrinsic) or inside a shape model (latent)."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.geometry.deformation_gradients import rotation_matrices
from caricli.geometry.fit_camera import fit_camera
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.slide_contour import slide_contour
from caricli.geometry.untangle import untangle
from caricli.structures import Camera

JAW = 17
PARTS = {
    "jaw": range(0, 17),
    "brows": range(17, 27),
    "nose": range(27, 36),
    "eyes": range(36, 48),
    "mouth": range(48, 68),
    "extra": range(68, 81),
}
MIN_KNOWN = 8


@dataclass(frozen=True)
class IntrinsicSettings:
    """Weights of the elastic fit. strength: of the landmarks against the surface. shrink: of the prior."""

    strength: float = 10.0
    shrink: float = 1.5e-4
    rounds: int = 10


@dataclass(frozen=True)
class LatentSettings:
    """Weights of the fit inside the model. noise: expected landmark error as a share of the landmarks' diagonal."""

    noise: float = 0.0125
    rounds: int = 4
    refinements: int = 6


@dataclass(frozen=True)
class LandmarkFit:
    """A fitted face.

    vertices (V, 3) metres; latent (D,); residual (V, 9) features beyond the latent, or None; pose in pixels; landmarks
    (L, 2) fitted pixels and anchors (L,) their vertex ids; nme and nme_latent (of the latent's own shape) and
    part_errors in percent; prior_rms; flipped share of triangles; rounds; settings.
    """

    vertices: np.ndarray
    latent: np.ndarray
    residual: np.ndarray | None
    pose: Camera
    landmarks: np.ndarray
    anchors: np.ndarray
    nme: float
    nme_latent: float
    prior_rms: float
    flipped: float
    part_errors: dict
    rounds: int
    settings: IntrinsicSettings | LatentSettings


def landmark_vertices(vertices, rotation, template, count):
    """(count,) vertex ids that the first landmarks stand on, those of the jaw on the outline of a posed face.

    vertices: (V, 3). rotation: (3, 3) of the camera. template: Template with the annotation.
    """
    note = template.annotation
    jaw = slide_contour(vertices, rotation, template.vertices, note.landmarks[:JAW], note.jaw_paths)
    return np.concatenate([jaw, note.landmarks[JAW:count]])


class _Observation:
    """Known landmarks in units of their diagonal around their centre, and where they can stand on the mesh."""

    def __init__(self, points, template):
        note = template.annotation
        if len(points) not in (68, len(note.landmarks)):
            expected = "68 or 81" if note.has_extra else "the 68 that the model's annotation has"
            raise InputError(f"expected {expected} landmarks, found {len(points)}")
        self.template, self.count = template, len(points)
        self.known = np.flatnonzero(np.isfinite(points).all(axis=1))
        if len(self.known) < MIN_KNOWN:
            raise InputError(f"expected at least {MIN_KNOWN} known landmarks, found {len(self.known)}")
        given = points[self.known]
        self.given, self.centre = points, given.mean(0)
        self.diagonal = float(np.linalg.norm(np.ptp(given, axis=0)))
        if self.diagonal == 0:
            raise InputError("all landmarks lie in one place")
        self.points = (given - self.centre) / self.diagonal

    def anchors(self, vertices, rotation):
        """(L,) vertex ids of all landmarks for a posed shape; the jaw slides to the outline."""
        return landmark_vertices(vertices, rotation, self.template, self.count)

    def settle(self, vertices, weights=None, rotation=None):
        """Camera and anchors that agree with each other. Returns (Camera in units of the diagonal, (L,) anchors)."""
        rotation = np.diag([1.0, -1.0, -1.0]) if rotation is None else rotation
        for _ in range(2):
            anchors = self.anchors(vertices, rotation)
            pose = self.pose(vertices, anchors, weights)
            rotation = pose.rotation
        return pose, anchors

    def pose(self, vertices, anchors, weights):
        """Camera in units of the diagonal for given anchors."""
        return fit_camera(vertices[anchors[self.known]], self.points, weights)

    def error(self, vertices, pose, anchors):
        """(K,) distances of the known landmarks as shares of the diagonal."""
        return np.linalg.norm(pose.project(vertices[anchors[self.known]]) - self.points, axis=1)

    def in_pixels(self, pose):
        """The same pose for the given picture."""
        translation = pose.translation * self.diagonal + self.centre
        return Camera(pose.scale * self.diagonal, pose.rotation, translation)


def fit_landmarks(points, model, method="intrinsic", prior_weight=1.0):
    """Fit a face by the method of a name.

    points: (L, 2) pixels, y down, NaN where unknown. model: ShapeModel, for "intrinsic" an IntrinsicModel. method:
    "intrinsic" or "latent". prior_weight: larger stays nearer to plausible faces, smaller nearer to the landmarks.
    Returns LandmarkFit. Raises InputError, NumericsError.
    """
    if method == "latent":
        return fit_landmarks_latent(points, model, LatentSettings(noise=LatentSettings.noise * prior_weight**0.5))
    if model.kind != "intrinsic":
        raise InputError(f"the method 'intrinsic' needs an intrinsic model, found one of kind {model.kind!r}")
    return fit_landmarks_intrinsic(points, model, IntrinsicSettings(shrink=IntrinsicSettings.shrink * prior_weight))


# The matrices are small: threads that wait for each other cost more than they bring, most of all on a busy machine.
@threadpool_limits.wrap(limits=1)
def fit_landmarks_intrinsic(points, model, settings=IntrinsicSettings()):  # noqa: B008 (frozen)
    """Fit a face whose surface follows the landmarks elastically while its features stay near the model's.

    Alternates, after Wu et al. 2018 (expressions paper 3.2.1): pose; jaw landmarks to the outline; the smoothest
    correction of the model's shape that takes the landmarks to their rays (depth is kept); and the latent as the shrunk
    projection of the result's deformation-gradient features. An outlier among the landmarks loses its weight. At the
    end flipped triangles are turned back and mouth cavity and eye sockets are tucked behind the skin.

    points: (L, 2) pixels, y down, NaN where unknown. model: IntrinsicModel. settings: IntrinsicSettings.
    Returns LandmarkFit; what the latent cannot express is in its residual. Raises InputError, NumericsError.
    """
    template, gradients = model.template, model.template.gradients
    seen = _Observation(points, template)
    latent, rotation = np.array(model.prior.mean), None
    weights = np.ones(len(seen.known))
    for round_number in range(settings.rounds):
        shape = model.decode(latent)
        pose, anchors = seen.settle(shape, weights, rotation)
        rotation, chosen = pose.rotation, anchors[seen.known]
        wanted = (seen.points - pose.project(shape[chosen])) / pose.scale
        if round_number >= 2:
            weights = _robust_weights(np.linalg.norm(wanted, axis=1) * pose.scale)
        correction = model.anchors.move(chosen, wanted, settings.strength, weights)
        vertices = shape + correction @ rotation[:2]
        latent = model.features_to_latent(gradients.features(vertices), settings.shrink)
    vertices = untangle(vertices, gradients)
    anchors = seen.anchors(vertices, rotation)
    pose = seen.pose(vertices, anchors, weights)
    wanted = (seen.points - pose.project(vertices[anchors[seen.known]])) / pose.scale
    vertices += model.anchors.move(anchors[seen.known], wanted, settings.strength, weights) @ pose.rotation[:2]
    vertices = template.cavities.tuck(vertices)
    features = gradients.features(vertices)
    latent = model.features_to_latent(features, settings.shrink)
    residual = features - model.features(latent)
    return _finish(seen, model, vertices, latent, residual, weights, rotation, settings.rounds, settings)


@threadpool_limits.wrap(limits=1)
def fit_landmarks_latent(points, model, settings=LatentSettings()):  # noqa: B008 (frozen)
    """Fit a face that stays inside a shape model (deformable paper, equation 3 and supplement 5).

    Minimises ``sum_k w_k |s R[:2] p_k(z) + t - b_k|^2 / noise^2 + |whitened z|^2`` over pose and latent: alternating
    rounds of pose, outline and latent, then Levenberg-Marquardt steps on all together, then a last pose. Only the
    points that landmarks can stand on are decoded.

    points: (L, 2) pixels, y down, NaN where unknown. model: any ShapeModel. settings: LatentSettings.
    Returns LandmarkFit without a residual. Raises InputError, NumericsError.
    """
    template = model.template
    seen = _Observation(points, template)
    candidates = template.annotation.anchor_ids()
    sparse = np.zeros_like(template.vertices)

    whitened = np.zeros(len(model.prior.mean))
    sparse[candidates] = model.decode_points(model.prior.colour(whitened), candidates)
    pose, anchors = seen.settle(sparse)
    weights = np.ones(len(seen.known))
    damping, rounds = 1e-3, settings.rounds + settings.refinements
    for round_number in range(rounds):
        joint = round_number >= settings.rounds
        latent = model.prior.colour(whitened)
        sparse[candidates] = model.decode_points(latent, candidates)
        if not joint:
            pose, anchors = seen.settle(sparse, weights, pose.rotation)
        else:
            anchors = seen.anchors(sparse, pose.rotation)
        if round_number >= 2:
            weights = _robust_weights(seen.error(sparse, pose, anchors))

        def cost(pose, whitened, anchors=anchors, weights=weights):
            sparse[candidates] = model.decode_points(model.prior.colour(whitened), candidates)
            error = seen.error(sparse, pose, anchors)
            return (weights * error**2).sum() / settings.noise**2 + (whitened**2).sum()

        positions, jacobian = model.points_jacobian(latent, anchors[seen.known])
        jacobian = jacobian @ model.prior.factor
        system, right = _normal_equations(positions, jacobian, pose, seen.points, weights, settings.noise)
        dimension = len(whitened)
        system[-dimension:, -dimension:] += np.eye(dimension)
        right[-dimension:] -= whitened
        if not joint:
            system, right = system[-dimension:, -dimension:], right[-dimension:]
        before = cost(pose, whitened)
        for _ in range(6):
            step = np.linalg.solve(system + damping * np.diag(np.diag(system)), right)
            trial = (_moved(pose, step[:6]) if joint else pose, whitened + step[-dimension:])
            if cost(*trial) < before:
                (pose, whitened), damping = trial, damping / 3
                break
            damping *= 5
    latent = model.prior.colour(whitened)
    return _finish(seen, model, model.decode(latent), latent, None, weights, pose.rotation, rounds, settings)


def _finish(seen, model, vertices, latent, residual, weights, rotation, rounds, settings):
    """Final pose and figures of a fit."""
    pose, anchors = seen.settle(vertices, weights, rotation)
    if pose.rotation[2, 2] > 0:
        raise InputError("the landmarks show a face from behind: are they mirrored, upside down, or in another order?")
    error = 100 * seen.error(vertices, pose, anchors)
    own = vertices if residual is None else model.decode(latent)
    own_error = 100 * seen.error(own, *seen.settle(own, weights, rotation))
    parts = {name: error[np.isin(seen.known, list(ids))] for name, ids in PARTS.items()}
    pixels = seen.in_pixels(pose)
    return LandmarkFit(
        vertices=vertices,
        latent=latent,
        residual=residual,
        pose=pixels,
        landmarks=pixels.project(vertices[anchors]),
        anchors=anchors,
        nme=float(error.mean()),
        nme_latent=float(own_error.mean()),
        prior_rms=float(model.prior.rms(latent)),
        flipped=float(flipped_triangles(vertices, model.template.gradients).mean()),
        part_errors={name: float(values.mean()) for name, values in parts.items() if len(values)},
        rounds=rounds,
        settings=settings,
    )


def _robust_weights(errors, tolerance=4.0, floor=0.02):
    """Weights in (0, 1] of Geman and McClure: errors far beyond the usual (at least ``floor``) lose theirs."""
    scale = tolerance * max(1.4826 * np.median(errors), floor)
    return np.maximum(1 / (1 + (errors / scale) ** 2) ** 2, 1e-4)


def _normal_equations(positions, jacobian, pose, points, weights, noise):
    """Gauss-Newton system (6 + D, 6 + D) and right side for [turn (3), log scale, shift (2), latent (D)]."""
    count, _, dimension = jacobian.shape
    camera = positions @ pose.rotation.T
    rows = np.zeros((count, 2, 6 + dimension))
    rows[:, 0, 1], rows[:, 0, 2] = camera[:, 2], -camera[:, 1]
    rows[:, 1, 0], rows[:, 1, 2] = -camera[:, 2], camera[:, 0]
    rows[:, :, 3] = camera[:, :2]
    rows[:, :, 6:] = np.einsum("ab,kbd->kad", pose.rotation[:2], jacobian)
    rows *= pose.scale
    rows[:, 0, 4] = rows[:, 1, 5] = 1.0
    scale = np.sqrt(weights)[:, None] / noise
    residual = ((points - pose.project(positions)) * scale).ravel()
    rows = (rows * scale[:, :, None]).reshape(2 * count, -1)
    return rows.T @ rows, rows.T @ residual


def _moved(pose, step):
    rotation = rotation_matrices(step[None, :3])[0] @ pose.rotation
    return Camera(pose.scale * float(np.exp(step[3])), rotation, pose.translation + step[4:])
