"""The camera that sees a face as a picture shows it."""

from dataclasses import dataclass

import numpy as np

from caricli.limits import MAX_CAMERA_SCALE, MAX_COORDINATE, MIN_CAMERA_SCALE
from caricli.structures.checks import refuse, shape_problem
from caricli.structures.zoomed_pixels import zoomed_pixels

_ORTHOGONAL = 1e-4


@dataclass(frozen=True, eq=False)
class Camera:
    """A scaled orthographic camera: pixels q = scale * rotation[:2] @ p + translation.

    scale: pixels per metre, from MIN_CAMERA_SCALE to MAX_CAMERA_SCALE.
    rotation: (3, 3), proper, from the face's axes to x right, y down, z into the picture.
    translation: (2,) pixels; (0, 0) is the centre of the top-left pixel.
    Raises InputError when it is no camera.
    """

    scale: float
    rotation: np.ndarray
    translation: np.ndarray

    def __post_init__(self) -> None:
        """Check that it is a camera."""
        for key, shape in (("scale", ()), ("rotation", (3, 3)), ("translation", (2,))):
            value = np.asarray(getattr(self, key), np.float64)
            refuse(shape_problem(f"camera_{key}", value, shape, MAX_COORDINATE))
            object.__setattr__(self, key, value if shape else float(value))
        if not MIN_CAMERA_SCALE <= self.scale <= MAX_CAMERA_SCALE:
            expected = f"from {MIN_CAMERA_SCALE:g} to {MAX_CAMERA_SCALE:g} pixels per metre"
            refuse(f"camera_scale: expected {expected}, found {self.scale:g}")
        far = not (np.abs(self.rotation) <= 1.001).all()
        if far or np.abs(self.rotation @ self.rotation.T - np.eye(3)).max() > _ORTHOGONAL or self._mirrors():
            refuse("camera_rotation: expected a proper rotation, found another matrix")

    def _mirrors(self) -> bool:
        return bool(np.linalg.det(self.rotation) < 0)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) to pixels (..., 2)."""
        return self.scale * points @ self.rotation[:2].T + self.translation

    def place(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) to pixels and depth in pixels (..., 3), as `rasterise` takes them."""
        return self.scale * points @ self.rotation.T + [*self.translation, 0]

    def lift(self, pixels: np.ndarray, points: np.ndarray) -> np.ndarray:
        """The 3D positions that project to pixels (K, 2) and keep the depth of points (K, 3)."""
        camera = points @ self.rotation.T
        camera[:, :2] = (pixels - self.translation) / self.scale
        return camera @ self.rotation

    def zoomed(self, zoom: float, corner: np.ndarray | tuple[float, float] = (0.0, 0.0)) -> "Camera":
        """The camera of the picture that `zoomed_pixels` goes to, for its zoom and corner."""
        return Camera(self.scale * zoom, self.rotation, zoomed_pixels(self.translation, zoom, corner))
