"""Ink: lines, hatching that swells in the shade, and solid blacks on paper."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.stylise.canvas import Canvas, step
from caricli.methods.stylise.flow import flow, lines

_PAPER = np.array([0.985, 0.97, 0.935], np.float32)
_INK = np.array([0.07, 0.06, 0.09], np.float32)


@dataclass(frozen=True)
class InkSettings:
    """Pen and paper; lengths in units.

    line: width of contours, and depth: contrast, 0 to 1, from which on they are black. contrast: share of a lightness's
    difference from that around it which is added to it. gap: between hatching lines, and closest: the same in pixels,
    at least. shades: lightness below which lines go in one more direction, and angles: these, degrees. bend: how far
    light bends lines, gaps. solid: lightness below which all is black.
    """

    line: float = 1.1
    depth: float = 0.09
    contrast: float = 0.35
    gap: float = 1.9
    closest: float = 3.5
    shades: tuple[float, ...] = (0.68, 0.42, 0.26)
    angles: tuple[float, ...] = (52.0, -28.0, 5.0)
    bend: float = 5.0
    solid: float = 0.11


def draw_ink(canvas: Canvas, settings: InkSettings = InkSettings()) -> np.ndarray:  # noqa: B008 (frozen)
    """Draw contours along the flow of the picture, and hatch what is dark with lines that bend with its light.

    Returns (H, W, 3) float32.
    """
    tone = canvas.blurred(canvas.light, 0.8)
    tone = np.clip(tone + settings.contrast * (tone - canvas.blurred(tone, 20)), 0, 1)
    ink = lines(canvas, flow(canvas, 1.5), settings.line, settings.depth)
    ink = step(ink - 0.45, 0.5)
    for shade, angle in zip(settings.shades, settings.angles, strict=True):
        ink = np.maximum(ink, _hatching(canvas, tone, shade, angle, settings))
    ink = np.maximum(ink, step(settings.solid - tone, 0.05))
    return _PAPER + ink[..., None] * (_INK - _PAPER)


def _hatching(canvas: Canvas, tone: np.ndarray, shade: float, angle: float, settings: InkSettings) -> np.ndarray:
    """(H, W) from 0 to 1: lines of ink, the wider the darker it is below ``shade``."""
    gap = max(settings.gap * canvas.unit, settings.closest)
    rows, columns = np.mgrid[: canvas.shape[0], : canvas.shape[1]].astype(np.float32)
    turn = np.radians(angle)
    # Light bends them, so that they lie on the form; the hand is a little unsteady.
    bend = settings.bend * canvas.blurred(tone, 6) + 0.25 * canvas.noise(14)
    phase = (columns * np.sin(turn) + rows * np.cos(turn)) / gap + bend
    ridge = 2 * np.abs(phase % 1 - 0.5)
    width = np.clip((shade - tone) / shade, 0, 1) * 0.75 + 0.06 * canvas.noise(2.5)
    drawn = step(shade - tone + 0.05 * canvas.noise(5), 0.04)
    return drawn * step(width - (1 - ridge), max(1.6 / gap, 0.12))
