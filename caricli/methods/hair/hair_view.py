"""What a picture shows of a head and its hair."""

import cv2
import numpy as np

from caricli.methods.hair.fit_outline import Outline
from caricli.methods.hair.mask_hair import HairMask
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera
from caricli.template.template import Template

_BEHIND = 0.01  # of the head's height: what is farther behind the surface is hidden


class HeadView:
    """A head as the camera sees it. camera: Camera."""

    def __init__(self, head: Template, camera: Camera, shape: tuple[int, ...]) -> None:
        """head: Template in the shape of the face. shape: H and W of the picture."""
        self.camera = camera
        rows, columns = shape
        self._depth = rasterise(camera.place(head.vertices), head.faces, columns, rows).depth
        self._close = _BEHIND * camera.scale * head.height

    def shows(self, points: np.ndarray) -> np.ndarray:
        """Whether points (..., 3) are in the picture and not behind the head."""
        x, y, z = np.moveaxis(self.camera.place(points), -1, 0)
        rows, columns = self._depth.shape
        pictured = (x >= 0) & (y >= 0) & (x < columns) & (y < rows)
        return pictured & (z < self._nearest(x, y) + self._close)

    def beside(self, points: np.ndarray) -> np.ndarray:
        """Whether points (..., 3) are beside the head in the picture."""
        x, y, _ = np.moveaxis(self.camera.place(points), -1, 0)
        return np.isinf(self._nearest(x, y))

    def _nearest(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        depth = sample_pixels(self._depth, x.ravel(), y.ravel(), cv2.INTER_NEAREST, float("inf"))
        return depth.reshape(x.shape)


class HairView(HeadView):
    """A head as the camera sees it, and where the picture shows that there is no hair.

    Bare is what is neither hair nor background, and the background beside the head in directions in which no hair
    stands out. hair: HairMask. outline: Outline of the hair.
    """

    def __init__(self, head: Template, camera: Camera, hair: HairMask, outline: Outline) -> None:
        """head: Template in the shape of the face. outline: around the middle of its directions."""
        super().__init__(head, camera, hair.pixels.shape)
        self.hair = hair
        self.outline = outline
        bare = ~hair.pixels & (~hair.behind | outline.bald(hair.pixels.shape))
        far = np.full(bare.shape, np.hypot(*bare.shape), np.float32)
        self._to_bare = exact_distance_to(bare) - exact_distance_to(~bare) if bare.any() else far

    def bare(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool, which of points (N, 3) lie in the picture where it has no hair, whatever is before them."""
        x, y = self.camera.project(points).T
        return sample_pixels(self.hair.pixels.astype(np.float32), x, y, border=1.0) < 0.5

    def to_bare(self, points: np.ndarray) -> np.ndarray:
        """Metres in the picture from points (..., 3) to where it is bare, below zero inside."""
        x, y, _ = np.moveaxis(self.camera.place(points), -1, 0)
        return sample_pixels(self._to_bare, x.ravel(), y.ravel()).reshape(x.shape) / self.camera.scale
