"""The landmarks of a picture against a template, and what a face is that was fitted to them."""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.geometry.alignment.fit_camera import fit_camera
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.outline import Outline
from caricli.methods.reconstruct.settings import IntrinsicSettings, LatentSettings, OutlierSettings
from caricli.models.shape_model import ShapeModel
from caricli.structures import Camera, Face
from caricli.structures.landmarks import COUNT, FEWEST, PARTS
from caricli.template.template import Template

_OUTLIERS = OutlierSettings()

_FOUND = 0.1
"""How strongly a landmark pulls that was found for sure, of how one does that was given."""

_REVERSED = 2.0
"""How much nearer the usual face comes to landmarks that are listed from the last to the first when they are read the
other way; to those of six drawings and a photograph 2.2 to 8.5 times."""

_CONVENTION = "pixels = scale * rotation[:2] @ vertex + translation; x right, y down, z into the picture"


@dataclass(frozen=True, eq=False)
class LandmarkFit:
    """A fitted face and how well it fits.

    face: Face in the template's topology, with camera, fitted landmarks, latent, and residual where there is one.
    anchors: (L,) vertex ids that the landmarks stand on.
    nme: percent, mean distance of the fitted landmarks to the given ones, of the diagonal of these.
    nme_latent: percent, the same for the shape of the latent alone.
    prior_rms: root mean square of the whitened latent, about 1 for a typical face.
    flipped: share of triangles that are turned over.
    part_errors: percent, mean distances by part of the face.
    settings: IntrinsicSettings or LatentSettings.
    rounds: iterations of the fit to landmarks that it took, of both where there were two; 0 where none was needed.
    outline: Outline of what was found in the picture besides, or None where nobody looked; in no error but those of
    detected ears, which are where it and the detector together say.
    neck: how many times as wide as landmarks alone tell it the neck is, because the picture shows it so.
    """

    face: Face
    anchors: np.ndarray
    nme: float
    nme_latent: float
    prior_rms: float
    flipped: float
    part_errors: dict[str, float]
    settings: IntrinsicSettings | LatentSettings
    rounds: int = 0
    outline: Outline | None = None
    neck: float = 1.0

    def figures(self) -> dict[str, Any]:
        """What reports say of the fit, as JSON."""
        camera = self.face.require_camera()
        return {
            "settings": asdict(self.settings),
            "nme": self.nme,
            "nme_latent": self.nme_latent,
            "part_errors": self.part_errors,
            "prior_rms": self.prior_rms,
            "flipped": self.flipped,
            "neck": self.neck,
            "pose": {
                "scale": camera.scale,
                "rotation": camera.rotation,
                "translation": camera.translation,
                "convention": _CONVENTION,
            },
            "anchors": np.asarray(self.anchors),
            "iterations": self.rounds,
        } | ({} if self.outline is None else {"found_landmarks": self.outline.figures()})

    def shown(self, points: np.ndarray) -> np.ndarray:
        """Given landmarks (L, 2) with those that were found in the picture."""
        return points if self.outline is None or len(points) > COUNT else self.outline.after(points)

    def describe(self) -> str:
        """What is printed of it."""
        return f"NME {self.nme:.2f} %, prior {self.prior_rms:.2f}, flipped {100 * self.flipped:.2f} %"


class Observation:
    """The landmarks that are known, in units of their diagonal around their centre, and where they can stand.

    ids: (K,) numbers of the known landmarks. points: (K, 2) their places in those units. trust: (K,) from 0 to 1, how
    strongly they pull. given: (K,) bool, those that were given and not found. asked: how many landmarks files have.
    count: L, of all landmarks, with those that can be found. doubts: (K, 2, 2) covariances of the places, in square
    units, or None where nothing is known of them.
    Cameras and errors of its methods are in those units too, but for ``in_pixels``.
    """

    def __init__(
        self,
        points: np.ndarray,
        template: Template,
        outline: Outline | None = None,
        spreads: np.ndarray | None = None,
    ) -> None:
        """points: (L, 2) pixels, y down, NaN where unknown. template: Template that they stand on. outline: what was
        found besides the 68, which pulls weakly, or besides detected landmarks, which have spreads. spreads: (L, 2, 2)
        covariances of the points, square pixels, or None.

        Raises InputError for another number of landmarks, too few known ones, all in one place, and reversed ones.
        """
        note = template.annotation
        if len(points) not in (68, len(note.landmarks)):
            expected = "68 or 81 landmarks" if note.has_extra else "68 landmarks, as the model has no others"
            raise InputError(f"expected {expected}, found {len(points)}")
        self.template = template
        self.asked = len(points)
        confidence = np.ones(len(points))
        if outline is not None and len(points) == COUNT:
            points = outline.after(points)
            confidence = np.concatenate([confidence, _FOUND * outline.confidence])
        elif outline is not None:
            assert spreads is not None
            points, spreads = outline.joined(points, spreads)
        self.count = len(points)
        self.ids = np.flatnonzero(np.isfinite(points).all(axis=1))
        if len(self.ids) < FEWEST:
            raise InputError(f"expected at least {FEWEST} known landmarks, found {len(self.ids)}")
        self.trust = confidence[self.ids]
        self.given = self.trust == 1
        given = points[self.ids[self.given]]
        self.centre = given.mean(0)
        self.diagonal = float(np.linalg.norm(np.ptp(given, axis=0)))
        if self.diagonal == 0:
            raise InputError("all landmarks lie in one place")
        if self._reversed(points[:COUNT]):
            raise InputError("the landmarks are listed in reversed order")
        self.points = (points[self.ids] - self.centre) / self.diagonal
        self.doubts = None if spreads is None else self._own_doubts(spreads)

    def _reversed(self, points: np.ndarray) -> bool:
        """Whether all of landmarks (68, 2) are known, and by an affine picture of the usual face listed backwards."""
        if not np.isfinite(points).all():
            return False
        places = self.template.vertices[self.template.annotation.landmarks[:COUNT]]
        columns = np.column_stack([places, np.ones(COUNT)])
        flat = columns @ np.linalg.pinv(columns)
        given, back = (np.linalg.norm(flat @ own - own) for own in (points, points[::-1]))
        return bool(given > _REVERSED * back)

    def _own_doubts(self, spreads: np.ndarray) -> np.ndarray:
        """Of spreads (L, 2, 2) of the given landmarks those of the known ones; what was found has none."""
        doubts = np.zeros((len(self.ids), 2, 2))
        doubts[self.given] = spreads[self.ids[self.given]] / self.diagonal**2
        return doubts

    def confidence(self, noise: float | np.ndarray) -> np.ndarray | None:
        """(K, 2, 2) how much the places say, of what they would if they were exact; None where they are.

        noise: how far a shape is expected from exact ones, of the diagonal; (K, 1, 1) where places differ in it.
        """
        if self.doubts is None:
            return None
        return np.linalg.inv(np.eye(2) + self.doubts / noise**2)

    def shares(self, weights: np.ndarray, noise: float) -> np.ndarray:
        """Weights (K,) lowered by the mean confidence of their landmarks."""
        confidence = self.confidence(noise)
        return weights if confidence is None else weights * np.trace(confidence, axis1=1, axis2=2) / 2

    def whitened(self, values: np.ndarray, noise: float) -> np.ndarray:
        """Values (K, 2, ...) across the picture as their doubts leave them: square sums count the confidence."""
        confidence = self.confidence(noise)
        if confidence is None:
            return values
        roots = np.linalg.cholesky(confidence).swapaxes(1, 2)
        return np.einsum("kab,kb...->ka...", roots, values)

    def anchors(self, vertices: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """(L,) vertex ids of all landmarks for a posed shape (V, 3); the jaw slides to the outline."""
        return landmark_vertices(vertices, rotation, self.template, self.count)

    def settle(
        self, vertices: np.ndarray, weights: np.ndarray | None = None, rotation: np.ndarray | None = None
    ) -> tuple[Camera, np.ndarray]:
        """Camera and anchors (L,) that agree with each other.

        vertices: (V, 3). weights: (K,) of the known landmarks. rotation: (3, 3) to begin with, or from the front.
        """
        rotation = np.diag([1.0, -1.0, -1.0]) if rotation is None else rotation
        for _ in range(2):
            anchors = self.anchors(vertices, rotation)
            camera = self.camera(vertices, anchors, weights)
            rotation = camera.rotation
        return camera, anchors

    def camera(self, vertices: np.ndarray, anchors: np.ndarray, weights: np.ndarray | None) -> Camera:
        """The Camera for given anchors (L,)."""
        return fit_camera(vertices[anchors[self.ids]], self.points, weights)

    def gaps(self, vertices: np.ndarray, camera: Camera, anchors: np.ndarray) -> np.ndarray:
        """(K, 2) metres across the picture from the anchors of the known landmarks to these."""
        return (self.points - camera.project(vertices[anchors[self.ids]])) / camera.scale

    def errors(
        self, vertices: np.ndarray, camera: Camera, anchors: np.ndarray, noise: float | None = None
    ) -> np.ndarray:
        """(K,) distances of the known landmarks as shares of the diagonal, ``whitened`` where a noise is given."""
        gaps = camera.project(vertices[anchors[self.ids]]) - self.points
        return np.linalg.norm(gaps if noise is None else self.whitened(gaps, noise), axis=1)

    def weights(self, errors: np.ndarray) -> np.ndarray:
        """(K,) of the known landmarks, from their errors (K,): less than trust for given ones that are far off.

        What was found has been doubted enough, and may be far from where a usual face has it.
        """
        return self.trust * np.where(self.given, outlier_weights(errors, _OUTLIERS), 1)

    def in_units(self, camera: Camera) -> Camera:
        """The camera of the given picture in units of the diagonal."""
        return Camera(camera.scale / self.diagonal, camera.rotation, (camera.translation - self.centre) / self.diagonal)

    def in_pixels(self, camera: Camera) -> Camera:
        """The same camera for the given picture."""
        translation = camera.translation * self.diagonal + self.centre
        return Camera(camera.scale * self.diagonal, camera.rotation, translation)

    def measure(
        self,
        face: Face,
        model: ShapeModel,
        weights: np.ndarray,
        settings: IntrinsicSettings | LatentSettings,
        seen_with: Camera | None = None,
    ) -> LandmarkFit:
        """The fit that a face is, but for its rounds: last camera, landmarks and figures.

        face: Face with a latent and the camera that it was found with, in units of the diagonal. model: of the latent.
        weights: (K,) of the known landmarks. seen_with: Camera in those units that is the last one, or None where the
        landmarks tell it.
        Raises InputError for a face that is seen from behind.
        """
        latent = face.require_latent()
        camera, anchors = self.settle(face.vertices, weights, _rotation(face))
        if seen_with is not None:
            camera = seen_with
            anchors = self.anchors(face.vertices, camera.rotation)
        if camera.rotation[2, 2] > 0:
            raise InputError(
                "the landmarks show a face from behind: are they mirrored, upside down, or in another order?"
            )
        errors = 100 * self.errors(face.vertices, camera, anchors)[self.given]
        own = face.vertices if face.residual is None else model.decode(latent)
        own_errors = 100 * self.errors(own, *self.settle(own, weights, _rotation(face)))[self.given]
        nme, part_errors = _means(errors, self.ids[self.given])
        pixels = self.in_pixels(camera)
        return LandmarkFit(
            face=replace(face, camera=pixels, landmarks=pixels.project(face.vertices[anchors[: self.asked]])),
            anchors=anchors[: self.asked],
            nme=nme,
            nme_latent=float(own_errors.mean()),
            prior_rms=float(model.prior.rms(latent)),
            flipped=float(flipped_triangles(face.vertices, model.template.gradients).mean()),
            part_errors=part_errors,
            settings=settings,
        )


def landmark_errors(landmarks: np.ndarray, points: np.ndarray) -> tuple[float, dict[str, float]]:
    """How far landmarks (L, 2) are from given points (L, 2), NaN where unknown, in the mean: all, and by PARTS.

    Percent of the diagonal of the points' box.
    """
    ids = np.flatnonzero(np.isfinite(points).all(axis=1))
    diagonal = np.linalg.norm(np.ptp(points[ids], axis=0))
    return _means(100 * np.linalg.norm(landmarks[ids] - points[ids], axis=1) / diagonal, ids)


def _means(errors: np.ndarray, ids: np.ndarray) -> tuple[float, dict[str, float]]:
    """The mean of errors (K,), and those of PARTS. ids: (K,) numbers of landmarks."""
    parts = {name: errors[np.isin(ids, list(numbers))] for name, numbers in PARTS.items()}
    return float(errors.mean()), {name: float(values.mean()) for name, values in parts.items() if len(values)}


def outlier_weights(errors: np.ndarray, settings: OutlierSettings) -> np.ndarray:
    """Weights (K,) of landmarks in (0, 1]: errors (K,) far beyond the usual lose theirs (Geman and McClure)."""
    scale = settings.tolerance * max(1.4826 * np.median(errors), settings.floor)
    return np.maximum(1 / (1 + (errors / scale) ** 2) ** 2, settings.least)


def _rotation(face: Face) -> np.ndarray | None:
    return None if face.camera is None else face.camera.rotation
