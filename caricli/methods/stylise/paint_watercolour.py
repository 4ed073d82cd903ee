"""Watercolour: thin washes that pool at their edges and settle in the grain of the paper."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.stylise.canvas import Canvas
from caricli.methods.stylise.flow import flow, lines
from caricli.render.pixels.levels import saturated, to_bytes, to_floats

_LIGHT = 0.72
_DEPTH = 0.12
_PENCIL = (0.32, 0.26, 0.24)
_SHEET = (1.0, 0.99, 0.965)


@dataclass(frozen=True)
class WatercolourSettings:
    """Washes, pigment and paper; lengths in units.

    wash: radius of what runs together, away from the face; and fine: on it. wobble: how far edges of washes waver.
    thin: exponent of the colours, below 1 thinner. saturation: of the pigment. edge: how much denser pigment is where
    washes end, pool: how unevenly it dries, and grain: how it settles in the paper. pencil: darkness of the drawing
    underneath.
    """

    wash: float = 2.6
    fine: float = 0.6
    wobble: float = 0.7
    thin: float = 0.62
    saturation: float = 1.5
    edge: float = 0.5
    pool: float = 0.2
    grain: float = 0.13
    pencil: float = 0.5


def paint_watercolour(
    canvas: Canvas,
    settings: WatercolourSettings = WatercolourSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """Paint washes whose pigment density changes the colour C to C - (C - C^2)(d - 1) (Bousseau et al. 2006).

    Returns (H, W, 3) float32.
    """
    coarse, fine = (_wash(canvas, units) for units in (settings.wash, settings.fine))
    wash = coarse + canvas.care[..., None] * (fine - coarse)
    wash = _wavering(canvas, wash, settings.wobble)
    colours = saturated(wash**settings.thin, settings.saturation)
    # The lightest parts are paper.
    colours = colours + (1 - colours) * np.clip((colours.min(2, keepdims=True) - _LIGHT) / (1 - _LIGHT), 0, 1)
    pool = 0.6 * canvas.noise(25) + 0.4 * canvas.noise(8)
    density = 1 + settings.edge * _edges(canvas, colours) + settings.pool * pool
    density = density + settings.grain * _paper(canvas)
    colours = colours - (colours - colours**2) * (density[..., None] - 1)
    drawing = settings.pencil * lines(canvas, flow(canvas, 1.2), 1.0, _DEPTH) * (0.4 + 0.6 * canvas.care)
    colours = colours * (1 - drawing[..., None] * (1 - np.array(_PENCIL, np.float32)))
    return np.clip(colours * np.array(_SHEET, np.float32), 0, 1)


def _wash(canvas: Canvas, units: float) -> np.ndarray:
    """Colours that run together over so many units, and stay apart where they differ."""
    radius = max(1, round(units * canvas.unit))
    levels = cv2.xphoto.oilPainting(to_bytes(canvas.image), radius, 1)
    smooth = cv2.medianBlur(levels, 2 * radius + 1)
    return canvas.blurred(to_floats(smooth), 0.15 * units)


def _wavering(canvas: Canvas, image: np.ndarray, units: float) -> np.ndarray:
    """A picture whose edges waver by so many units, less on the face."""
    rows, columns = np.mgrid[: canvas.shape[0], : canvas.shape[1]].astype(np.float32)
    amount = units * canvas.unit * (1 - 0.8 * canvas.care)
    across, down = (amount * (canvas.noise(6) + 0.5 * canvas.noise(2)) for _ in range(2))
    return cv2.remap(image, columns + across, rows + down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)


def _edges(canvas: Canvas, colours: np.ndarray) -> np.ndarray:
    """(H, W) from 0 to 1, where one wash ends and pigment gathers."""
    smooth = canvas.blurred(colours, 0.4)
    across, down = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    slope = np.sqrt((across**2 + down**2).sum(2)) * max(canvas.unit, 1)
    return canvas.blurred(np.clip(slope / 1.5, 0, 1), 0.2)


def _paper(canvas: Canvas) -> np.ndarray:
    """(H, W), the roughness of cold-pressed paper, of deviation near 1."""
    rough = 0.5 * canvas.noise(0.6) + 0.7 * canvas.noise(1.4) + 0.4 * canvas.noise(3)
    return rough / max(float(rough.std()), 1e-6)
