"""Where in a picture skin, hair and background are, by the face that was fitted to it."""

import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt

from caricli.methods.hair.face_size import face_size
from caricli.methods.hair.settings import MaskSettings
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.inside_polygon import inside_polygon
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Face
from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    BROWS,
    COUNT,
    EYE_LEFT,
    EYE_RIGHT,
    LIPS,
    OUTLINE,
    POINT_NAMES,
)
from caricli.structures.zoomed_pixels import zoomed_pixels
from caricli.template.annotation import EARS
from caricli.template.template import Template

_FEATURES = (BROW_RIGHT, BROW_LEFT, EYE_RIGHT, EYE_LEFT, LIPS)
_BROW_WIDTH = 0.06  # of the face's size
_EAR_ENDS = (3, 13)  # of the jaw: the lowest that ears hang
_FEWEST = 200  # pixels of background


class PictureZones:
    """The surroundings of a face in a picture, shrunk, and what is usually where in it.

    picture: (h, w, 3) uint8. size: pixels, the face's. enclosed: what the landmarks enclose. inner: surely skin.
    features: brows, eyes, mouth. behind: surely background, above the chin. above_chin, close: pixels above the chin,
    and next to the head. ears: (h, w) from 0 to 1, near projected ears. brows: row of the brows. prior: (h, w, 3)
    logarithms of how usual skin, hair and background are. All else (h, w) bool.
    """

    def __init__(self, face: Face, template: Template, image: np.ndarray, settings: MaskSettings) -> None:
        self._cut(face, image, settings)
        points = self.points
        rows, columns = np.mgrid[: self.shape[0], : self.shape[1]]
        self.enclosed = inside_polygon(points[list(OUTLINE)], self.shape)
        self.features = facial_features(points, self.size, self.shape, settings)
        self.inner = (distance_transform_edt(self.enclosed) > settings.core * self.size) & ~self.features
        self.brows = points[list(BROWS), 1].mean()
        placed = face.require_camera().zoomed(self.zoom, self.corner).place(face.vertices)
        raster = rasterise(placed, face.faces, self.shape[1], self.shape[0])
        self.mesh = raster.face >= 0
        skull = self.mesh & (rows < points[POINT_NAMES["nose_root"], 1])
        self.outside = distance_transform_edt(~(self.enclosed | skull)) / self.size
        self.close = self.outside < 0.15
        self.above_brows = rows < self.brows
        self.above_chin = rows < points[POINT_NAMES["chin"], 1]
        self.far = self.outside > min(settings.far, np.quantile(self.outside, 0.9))
        self.behind = self.far & self.above_chin
        if self.behind.sum() < _FEWEST:
            self.behind = self.far
        ear = self.mesh & template.mask(*EARS)[face.faces].any(1)[raster.face]
        self.ears = self._ears(ear, rows, settings)
        self.prior = self._prior(rows, settings)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.picture.shape[:2]

    def enlarged(self, mask: np.ndarray, around: float = 0.0) -> np.ndarray:
        """(H, W) bool of the whole picture for one (h, w) of its part here, and a value around it."""
        height, width = self.whole
        shift = np.array([[1 / self.zoom, 0, 0], [0, 1 / self.zoom, 0]])
        shift[:, 2] = self.corner + (1 / self.zoom - 1) / 2
        large = cv2.warpAffine(mask.astype(np.float32), shift, (width, height), borderValue=around)
        return large > 0.5

    def _cut(self, face: Face, image: np.ndarray, settings: MaskSettings) -> None:
        points = face.require_landmarks()[:COUNT]
        low = points.min(0)
        high = points.max(0)
        size = face_size(face)
        self.whole = image.shape[:2]
        start = np.clip(np.floor(low - settings.around * size), 0, None).astype(int)
        end = np.ceil(high + size * np.array([settings.around, settings.below])).astype(int)
        part = np.ascontiguousarray(image[start[1] : end[1], start[0] : end[0]])
        zoom = min(1.0, settings.side / max(part.shape[:2]))
        self.picture = cv2.resize(part, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA) if zoom < 1 else part
        self.zoom = zoom
        self.corner = start
        self.size = zoom * size
        self.points = zoomed_pixels(points, zoom, start)

    def _ears(self, ear: np.ndarray, rows: np.ndarray, settings: MaskSettings) -> np.ndarray:
        level = (rows > self.brows) & (rows < self.points[list(_EAR_ENDS), 1].mean())
        if not ear.any():
            return np.zeros(self.shape)
        near = np.exp(-((distance_transform_edt(~ear) / self.size / settings.ear) ** 2))
        return near * (level & ~self.enclosed & (self.outside < settings.reach))

    def _prior(self, rows: np.ndarray, settings: MaskSettings) -> np.ndarray:
        below = np.clip((rows - self.points[POINT_NAMES["chin"], 1]) / self.size, 0, None)
        outer = self.outside
        hair = 0.6 * _falling(outer, settings.reach, settings.blur) * _falling(below, 0.1, 0.08)
        hair = np.where(self.enclosed, 0.02, hair) * (1 - 0.6 * self.ears)
        top = _falling((rows - self.brows) / self.size, -settings.forehead, settings.blur)
        skin = np.where(self.mesh | (outer < 0.04), 0.4, 0.08) * (1 - 0.9 * top)
        skin = np.where(self.enclosed, 0.98, skin) + self.ears
        beside = (outer < 0.03) & (rows < self.brows)
        behind = np.where(self.enclosed, 0.0005, np.where(beside, 0.2, 0.5))
        hair = np.where(self.far, 0.003, hair)
        behind = np.where(self.far, 0.995, behind)
        chances = np.stack([skin, hair, behind], -1)
        return np.log(np.maximum(chances / chances.sum(-1, keepdims=True), 1e-5))


def facial_features(points: np.ndarray, size: float, shape: tuple[int, int], settings: MaskSettings) -> np.ndarray:
    """(H, W) bool: brows, eyes and lips of landmarks, with a margin; whatever their colours, they are not hair.

    points: (68, 2) pixels. size: pixels, of the face. shape: H and W.
    """
    mask = np.zeros(shape, np.uint8)
    for part in (BROW_RIGHT, BROW_LEFT):
        line = np.round(points[list(part)]).astype(np.int32)
        cv2.polylines(mask, [line], False, 1, max(1, int(_BROW_WIDTH * size)))
    enclosed = np.any([inside_polygon(points[list(part)], shape) for part in _FEATURES], axis=0)
    mask = (mask > 0) | enclosed
    return exact_distance_to(mask) < settings.features * size if mask.any() else mask


def _falling(values: np.ndarray, middle: float, width: float) -> np.ndarray:
    """From 1 below a middle to 0 above it."""
    return 1 / (1 + np.exp(np.clip((values - middle) / width, -30, 30)))
