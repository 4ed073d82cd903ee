"""Oil: brush strokes in layers, coarse to fine, that leave ridges in the paint."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.special import ndtr

from caricli.methods.stylise.canvas import Canvas
from caricli.methods.stylise.flow import flow, smeared
from caricli.render.pixels.levels import saturated, to_bytes, to_floats

_SHIFT = 4  # binary digits of a pixel's parts, for OpenCV's lines
_THICK = 128  # of 255: the ground's paint
_THINNEST = 0.5  # pixels, radius of a brush
_SOFT = 0.35  # of its radius: how much a brush blurs what it sees
_SLACK = 0.02  # difference of colours, of three channels together, that ends no stroke
_APART = 1.25  # of its radius: between strokes of a brush
_SHORTEST = 2  # steps that every stroke goes
_BROAD = 3.0
_NARROW = 1.2  # units over which the ways of coarse and of fine brushes are smoothed
_LIT = 0.25  # of the light, at most


@dataclass(frozen=True)
class OilSettings:
    """Brushes and paint.

    brushes: radii in units, coarse to fine. fine: least radius, units, away from the face, where brushes are coarser;
    on it all are used. miss: difference of colour, 0 to 1, from which on a finer brush corrects a coarser one. steps:
    of a stroke's way, each as long as the radius, at most. jitter: of the colours of strokes. bristle: how strongly
    hairs of the brush show, and ridge: borders of strokes. saturation: of the paint. calm: share of jitter, ridges and
    misses that are left on the face.
    """

    brushes: tuple[float, ...] = (8.0, 4.0, 2.0, 1.0, 0.5, 0.3)
    fine: float = 1.6
    miss: float = 0.045
    steps: int = 9
    jitter: float = 0.018
    bristle: float = 0.05
    ridge: float = 0.35
    saturation: float = 1.2
    calm: float = 0.55


def paint_oil(canvas: Canvas, settings: OilSettings = OilSettings()) -> np.ndarray:  # noqa: B008 (frozen)
    """Paint with curved strokes of several brushes (Hertzmann 1998), lit from the upper left.

    Returns (H, W, 3) float32.
    """
    broad = flow(canvas, _BROAD)
    narrow = flow(canvas, _NARROW)
    calm = 1 - (1 - settings.calm) * canvas.care
    ground = to_bytes(canvas.blurred(canvas.image, settings.brushes[0]))
    # Beside the colours, of every stroke how thick its paint is.
    paint = np.dstack([ground, np.full(canvas.shape, _THICK, np.uint8)])
    for number, units in enumerate(settings.brushes):
        ways = broad if units > _NARROW else narrow
        brush = _Brush(canvas.blurred(canvas.image, _SOFT * units), ways, max(units * canvas.unit, _THINNEST))
        miss = np.abs(to_floats(paint[..., :3]) - brush.wanted).mean(2) if number else np.ones(canvas.shape, np.float32)
        allowed = units >= settings.fine * (1 - canvas.care)
        starts, chance = brush.starts(miss * allowed / calm, settings.miss, canvas.generator)
        brush.draw(paint, starts, chance, settings)
        if brush.radius == _THINNEST:
            break
    colours = saturated(to_floats(paint[..., :3]), settings.saturation)
    relief = calm * _relief(canvas, paint[..., 3], broad, settings)
    return np.clip(colours * (1 + relief)[..., None], 0, 1)


@dataclass(frozen=True, eq=False)
class _Brush:
    """One brush. wanted: (H, W, 3) float32, the picture as it sees it. ways: of ``flow``. radius: pixels."""

    wanted: np.ndarray
    ways: np.ndarray
    radius: float

    def starts(self, miss: np.ndarray, least: float, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """(N, 2) pixels where strokes begin, in the order of painting: in every square of a brush where it is needed.

        miss: (H, W), how far the colours are off. least: miss from which on a stroke is needed.
        Also returns chance (N, 5), normal, of the strokes. Both are drawn for all squares, so that what the picture
        shows in one place changes no stroke in another.
        """
        height, width = miss.shape
        side = max(_APART * self.radius, 1.4)
        cells = np.stack(np.meshgrid(np.arange(0, width, side), np.arange(0, height, side)), -1).reshape(-1, 2)
        places = generator.permutation(cells + side * generator.random(cells.shape))
        chance = generator.normal(size=(len(places), 5))
        mean = cv2.blur(miss, [max(1, round(side))] * 2)
        x, y = np.minimum(places, [width - 1, height - 1]).astype(int).T
        needed = mean[y, x] > least
        return places[needed], chance[needed]

    def draw(self, paint: np.ndarray, starts: np.ndarray, chance: np.ndarray, settings: OilSettings) -> None:
        """Draw strokes from ``starts`` onto paint (H, W, 4) uint8. chance: of ``starts``, too."""
        colours = self._at(self.wanted, starts)
        ways, lengths = self._ways(starts, colours, self._at(to_floats(paint[..., :3]), starts), settings.steps)
        colours = to_bytes(colours + settings.jitter * (chance[:, :1] + chance[:, 1:4] / 2))
        heights = (256 * ndtr(chance[:, 4])).astype(int)
        pixels = np.rint(ways * 2**_SHIFT).astype(np.int32)
        width = max(1, round(2 * self.radius))
        rows = zip(pixels, lengths.tolist(), np.column_stack([colours, heights]).tolist(), strict=True)
        for way, length, colour in rows:
            cv2.polylines(paint, [way[:length]], False, colour, width, cv2.LINE_AA, _SHIFT)

    def _ways(
        self, starts: np.ndarray, colours: np.ndarray, under: np.ndarray, steps: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """(N, steps + 1, 2) pixels along the flow, and how many of them (N,) strokes take.

        A stroke ends where what lies under it, (N, 3), is nearer to the picture than its own colour.
        """
        places = starts
        before = np.zeros_like(starts)
        ways = [places]
        going = np.ones(len(starts), bool)
        lengths = np.ones(len(starts), int)
        for number in range(steps):
            way = self._at(self.ways, places)
            way = way * np.where((way * before).sum(1) < 0, -1.0, 1.0)[:, None]
            places = places + self.radius * way
            before = way
            ways.append(places)
            seen = self._at(self.wanted, places)
            off, kept = (np.abs(seen - shade).sum(1) for shade in (colours, under))
            going &= (off <= kept + _SLACK) | (number < _SHORTEST)
            lengths += going
        return np.stack(ways, 1), lengths

    def _at(self, values: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Values (N, C) at places (N, 2), those of the border outside."""
        height, width = values.shape[:2]
        x, y = np.clip(np.rint(places), 0, [width - 1, height - 1]).astype(int).T
        return values[y, x]


def _relief(canvas: Canvas, thickness: np.ndarray, ways: np.ndarray, settings: OilSettings) -> np.ndarray:
    """(H, W) how much lighter the paint is for its ridges and the furrows of bristles, in light from the upper left."""
    hairs = smeared(canvas.generator.normal(size=canvas.shape).astype(np.float32), ways, 8 * canvas.unit)
    hairs /= max(float(hairs.std()), 1e-6)
    ridges = canvas.blurred(to_floats(thickness), 0.3)
    height = settings.ridge * ridges + settings.bristle * canvas.blurred(hairs, 0.2)
    slope = cv2.Sobel(height, cv2.CV_32F, 1, 0, ksize=3) + cv2.Sobel(height, cv2.CV_32F, 0, 1, ksize=3)
    return np.clip(slope / 8 * max(canvas.unit, 1.0) ** 0.5, -_LIT, _LIT)
