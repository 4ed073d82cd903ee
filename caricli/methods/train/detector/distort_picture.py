"""Pictures whose faces are drawn out and pressed together as caricaturists do it, more than meshes are exaggerated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from caricli.methods.train.detector.scale_part import PartScale
from caricli.structures.detection import FaceFrame, MarkedPicture, turn_axes
from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    BROWS,
    EAR_LEFT,
    EAR_RIGHT,
    EYE_LEFT,
    EYE_RIGHT,
    EYES,
    FOREHEAD,
    LIPS,
    NOSE,
)
from caricli.structures.parsing import BEYOND

_FAR = 4.0
"""Sides of a face, from its middle, up to which heights are told apart."""

_STEP = 0.02
_END = 1.2
"""Sides of a face, from its middle, beyond which nothing is distorted."""

_SMALLEST = 0.06
"""Half of a part's height or width, sides of the face, at the least."""

_STRIDE = 4
"""Pixels between two places whose source is computed; between them it is interpolated."""

_CHIN = (*range(5, 12), 57)
_SCALED = (
    (LIPS,),
    (NOSE,),
    (_CHIN,),
    ((*range(2, 15), *LIPS),),
    (EYE_RIGHT, EYE_LEFT),
    ((*EYE_RIGHT, *BROW_RIGHT), (*EYE_LEFT, *BROW_LEFT)),
    ((*BROWS, *FOREHEAD),),
    ((*EYES, *BROWS, *FOREHEAD),),
    (EAR_RIGHT, EAR_LEFT),
)
"""Parts of a face that may be scaled, each with its pieces on the right and the left: mouth, nose, chin, lower half,
eyes without and with brows, forehead without and with eyes, ears.
"""


@dataclass(frozen=True)
class DistortSettings:
    """How faces are distorted; lengths are shares of the face's side.

    heights, widths: deviations of the logarithms of what heights and widths are multiplied by. aside: deviation of what
    heights are moved aside by. knots: heights over a face that are told apart. scaled: share of the parts that are
    scaled. factor: by what, between; uneven: deviation of the logarithm of what its width and its height differ by;
    askew: of what is drawn for each of both sides; extremes: of all together. anchor: how far from a part's middle the
    point is that stays in its place, at most, of half of its width and height.
    """

    heights: float = 0.22
    widths: float = 0.15
    aside: float = 0.03
    knots: int = 5
    scaled: float = 0.3
    factor: tuple[float, float] = (0.65, 1.7)
    uneven: float = 0.25
    extremes: tuple[float, float] = (0.6, 1.9)
    askew: float = 0.05
    anchor: float = 0.7


@dataclass(frozen=True, eq=False)
class Distortion:
    """A smooth map of the plane without folds that can be gone both ways.

    Within the frame of a face heights are stretched and pressed together, each height is made wider or narrower and
    moved aside, then parts are scaled one after the other, and at last all is.

    frame: FaceFrame. heights, stretched: (T,) heights before and after, sides of the face from its middle. widths,
    aside: (T,) factor of the width and what is added, at ``heights``. parts: PartScales in sides of the face. scale: of
    all.
    """

    frame: FaceFrame
    heights: np.ndarray
    stretched: np.ndarray
    widths: np.ndarray
    aside: np.ndarray
    parts: tuple[PartScale, ...] = ()
    scale: float = 1.0

    def places(self, points: np.ndarray) -> np.ndarray:
        """Where points (..., 2), pixels, are afterwards."""
        across, down = self._local(points)
        wide = across * np.interp(down, self.heights, self.widths) + np.interp(down, self.heights, self.aside)
        local = np.stack([wide, np.interp(down, self.heights, self.stretched)], -1)
        for part in self.parts:
            local = part.places(local)
        return self._global(self.scale * local)

    def sources(self, points: np.ndarray) -> np.ndarray:
        """Where what is afterwards at points (..., 2), pixels, came from."""
        local = np.stack(self._local(points), -1) / self.scale
        for part in reversed(self.parts):
            local = part.sources(local)
        wide, stretched = np.moveaxis(local, -1, 0)
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
    distortion = Distortion(frame, heights, stretched, widths, aside)
    places = np.stack(distortion._local(distortion.places(landmarks)), -1)
    scales = []
    for part in generator.permutation(len(_SCALED))[: generator.binomial(len(_SCALED), settings.scaled)]:
        for scale in _scales(places, _SCALED[part], settings, generator):
            scales.append(scale)
            places = scale.places(places)
    side = FaceFrame.of(distortion._global(places)).side
    return replace(distortion, parts=tuple(scales), scale=frame.side / side)


def _scales(
    places: np.ndarray, part: tuple[Sequence[int], ...], settings: DistortSettings, generator: np.random.Generator
) -> list[PartScale]:
    """How the pieces of a part are scaled. places: (L, 2) landmarks in sides of the face."""
    alike = generator.uniform(*np.log(settings.factor))
    uneven = settings.uneven * generator.normal() * np.array([0.5, -0.5])
    anchor = generator.uniform(-settings.anchor, settings.anchor, 2)
    scales = []
    for side, piece in enumerate(part):
        low = places[list(piece)].min(0)
        high = places[list(piece)].max(0)
        radii = np.maximum((high - low) / 2, _SMALLEST)
        logarithms = alike + uneven + settings.askew * generator.normal(size=2)
        factors = np.clip(np.exp(logarithms), *settings.extremes)
        outwards = np.array([-1 if side else 1, 1])
        scales.append(PartScale((low + high) / 2 + outwards * anchor * radii, radii * factors, factors))
    return scales


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
