"""Pictures whose faces are drawn out and pressed together as caricaturists do it, more than meshes are exaggerated."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from caricli.structures.detection import FaceFrame, MarkedPicture, turn_axes
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, JAW, MOUTH, NOSE
from caricli.structures.parsing import BEYOND

_FAR = 4.0
"""Sides of a face, from its middle, up to which heights are told apart."""

_STEP = 0.02
_END = 1.2
"""Sides of a face, from its middle, beyond which nothing is distorted."""

_STRIDE = 4
"""Pixels between two places whose source is computed; between them it is interpolated."""

_BULGES = (MOUTH, NOSE, EYE_RIGHT, EYE_LEFT, JAW)
"""Parts of a face that may be made larger or smaller alone."""


@dataclass(frozen=True)
class DistortSettings:
    """How faces are distorted; lengths are shares of the face's side.

    heights, widths: deviations of the logarithms of what heights and widths are multiplied by. aside: deviation of what
    heights are moved aside by. knots: heights over a face that are told apart. bulged: chance that a part alone is made
    larger or smaller; bulge: by which share at its middle, between; radius: of what is, between.
    """

    heights: float = 0.3
    widths: float = 0.2
    aside: float = 0.03
    knots: int = 5
    bulged: float = 0.6
    bulge: tuple[float, float] = (-0.3, 0.8)
    radius: tuple[float, float] = (0.25, 0.6)


@dataclass(frozen=True, eq=False)
class Distortion:
    """A smooth map of the plane without folds that can be gone both ways.

    Within the frame of a face heights are stretched and pressed together, each height is made wider or narrower and
    moved aside, then a disc is magnified, and all is scaled.

    frame: FaceFrame. heights, stretched: (T,) heights before and after, sides of the face from its middle. widths,
    aside: (T,) factor of the width and what is added, at ``heights``. centre: (2,) of the disc. radii, magnified: (R,)
    distances from it before and after. scale: of all.
    """

    frame: FaceFrame
    heights: np.ndarray
    stretched: np.ndarray
    widths: np.ndarray
    aside: np.ndarray
    centre: np.ndarray
    radii: np.ndarray
    magnified: np.ndarray
    scale: float = 1.0

    def places(self, points: np.ndarray) -> np.ndarray:
        """Where points (..., 2), pixels, are afterwards."""
        across, down = self._local(points)
        wide = across * np.interp(down, self.heights, self.widths) + np.interp(down, self.heights, self.aside)
        local = np.stack([wide, np.interp(down, self.heights, self.stretched)], -1)
        return self._global(self.scale * _radial(local, self.centre, self.radii, self.magnified))

    def sources(self, points: np.ndarray) -> np.ndarray:
        """Where what is afterwards at points (..., 2), pixels, came from."""
        local = np.stack(self._local(points), -1) / self.scale
        wide, stretched = np.moveaxis(_radial(local, self.centre, self.magnified, self.radii), -1, 0)
        down = np.interp(stretched, self.stretched, self.heights)
        across = (wide - np.interp(down, self.heights, self.aside)) / np.interp(down, self.heights, self.widths)
        return self._global(np.stack([across, down], -1))

    def _local(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        local = (points - self.frame.centre) @ turn_axes(self.frame.roll).T / self.frame.side
        return local[..., 0], local[..., 1]

    def _global(self, local: np.ndarray) -> np.ndarray:
        return self.frame.side * local @ turn_axes(self.frame.roll) + self.frame.centre


def distort_picture(
    picture: MarkedPicture, face: int, settings: DistortSettings, generator: np.random.Generator
) -> MarkedPicture:
    """Distort a picture about one of its faces, which keeps its size.

    face: its number. Returns a picture of the same size; what lies beyond the edges is of the region BEYOND.
    """
    import cv2

    distortion = random_distortion(picture.landmarks[face], settings, generator)
    height, width = picture.regions.shape
    columns, rows = np.meshgrid(np.arange(0, width + _STRIDE, _STRIDE), np.arange(0, height + _STRIDE, _STRIDE))
    sources = distortion.sources(np.stack([columns, rows], -1).astype(float)).astype(np.float32)
    finer = np.array([[_STRIDE, 0, 0], [0, _STRIDE, 0]], np.float32)
    x, y = np.moveaxis(cv2.warpAffine(sources, finer, (width, height), flags=cv2.INTER_LINEAR), -1, 0)
    pixels = cv2.remap(picture.pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    regions = cv2.remap(picture.regions, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=(BEYOND,))
    points = distortion.places(picture.landmarks)
    inside = ((points >= -0.5) & (points <= np.array([width, height]) - 0.5)).all(-1)
    return replace(picture, pixels=pixels, regions=regions, landmarks=points, visible=picture.visible & inside)


def random_distortion(landmarks: np.ndarray, settings: DistortSettings, generator: np.random.Generator) -> Distortion:
    """Draw a distortion for the face of landmarks (L, 2), pixels, whose side stays as it is."""
    frame = FaceFrame.of(landmarks)
    heights = _heights()
    slopes = np.exp(settings.heights * _smooth(settings.knots, generator))
    stretched = np.cumsum(slopes) * _STEP
    stretched -= np.interp(0, heights, stretched)
    widths = np.exp(settings.widths * _smooth(settings.knots, generator))
    aside = settings.aside * _smooth(settings.knots, generator)
    amount = generator.uniform(*settings.bulge) if generator.random() < settings.bulged else 0.0
    radius = generator.uniform(*settings.radius)
    radii = np.linspace(0, _FAR, 401)
    magnified = radii * (1 + amount * np.maximum(0, 1 - (radii / radius) ** 2) ** 2)
    still = Distortion(frame, heights, stretched, widths, aside, np.zeros(2), radii, radii)
    part = landmarks[list(_BULGES[generator.integers(len(_BULGES))])].mean(0)
    centre = np.stack(still._local(still.places(part)))
    moved = replace(still, centre=centre, magnified=magnified)
    return replace(moved, scale=frame.side / FaceFrame.of(moved.places(landmarks)).side)


@cache
def _heights() -> np.ndarray:
    """(T,) heights over a face at which a distortion is told, sides of the face."""
    return np.arange(-_FAR, _FAR + _STEP / 2, _STEP)


@cache
def _splines(knots: int) -> np.ndarray:
    """(T, knots) cubic splines over the heights that are 1 at one knot and 0 at the others."""
    from scipy.interpolate import CubicSpline

    ends = np.concatenate([[-_END], np.linspace(-0.6, 0.6, knots), [_END]])
    values = np.pad(np.eye(knots), ((1, 1), (0, 0)))
    splines = CubicSpline(ends, values, bc_type="clamped")(_heights())
    return np.where(np.abs(_heights())[:, None] < _END, splines, 0)


def _smooth(knots: int, generator: np.random.Generator) -> np.ndarray:
    """(T,) smooth noise of deviation 1 over a face, which goes to nothing beside it."""
    return np.clip(_splines(knots) @ generator.normal(size=knots), -2.5, 2.5)


def _radial(points: np.ndarray, centre: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Points (..., 2) whose distance from a centre changes from ``before`` to ``after``."""
    apart = points - centre
    distance = np.linalg.norm(apart, axis=-1, keepdims=True)
    return centre + apart * np.interp(distance, before, after) / np.maximum(distance, 1e-9)
