"""Pencil: strokes of graphite that catch on the grain of the paper."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.stylise.canvas import Canvas, step
from caricli.methods.stylise.flow import flow, lines, smeared

_PAPER = np.array([0.975, 0.965, 0.94], np.float32)
_GRAPHITE = np.array([0.15, 0.15, 0.17], np.float32)


@dataclass(frozen=True)
class PencilSettings:
    """Graphite and paper; lengths in units.

    line: width of contours, and depth: contrast, 0 to 1, from which on they are dark. contrast: share of a lightness's
    difference from that around it which is added to it. stroke: length of shading strokes, and angle: theirs, degrees.
    shade: how dark shading becomes, and dark: where it begins, lightness. grain: how strongly paper shows.
    """

    line: float = 0.9
    depth: float = 0.075
    contrast: float = 0.3
    stroke: float = 14.0
    angle: float = 55.0
    shade: float = 0.9
    dark: float = 0.88
    grain: float = 0.35


def draw_pencil(canvas: Canvas, settings: PencilSettings = PencilSettings()) -> np.ndarray:  # noqa: B008 (frozen)
    """Draw contours, and shade with strokes in one direction and, where it is dark, across (Lu, Xu and Jia 2012).

    Returns (H, W, 3) float32.
    """
    tone = canvas.blurred(canvas.light, 0.3)
    tone = np.clip(tone + settings.contrast * (tone - canvas.blurred(tone, 20)), 0, 1)
    pressure = np.clip((settings.dark - tone) / settings.dark, 0, 1) ** 1.25
    grain = canvas.noise(0.5) + 0.6 * canvas.noise(1.2)
    grain = settings.grain * grain / max(float(grain.std()), 1e-6)
    strokes = _strokes(canvas, settings.angle, settings.stroke)
    across = _strokes(canvas, settings.angle - 75, 0.7 * settings.stroke)
    texture = strokes + step(pressure - 0.5, 0.4) * across
    # Light pressure catches on every other fibre, strong pressure on all.
    laid = pressure ** np.exp(np.clip(-0.42 * texture - grain, -2, 2))
    ways = flow(canvas, 1.2)
    contour = lines(canvas, ways, settings.line, settings.depth)
    contour = np.clip(contour * (0.9 + 0.5 * grain), 0, 1)
    graphite = 1 - (1 - settings.shade * laid * (1 + 0.07 * (strokes + across))) * (1 - 0.8 * contour)
    return _PAPER + np.clip(graphite, 0, 1)[..., None] * (_GRAPHITE - _PAPER)


def _strokes(canvas: Canvas, angle: float, length: float) -> np.ndarray:
    """(H, W) of deviation near 1: parallel strokes of so many units, slightly bent."""
    turn = np.radians(angle) + 0.12 * canvas.noise(30)
    ways = np.dstack([np.cos(turn), -np.sin(turn)]).astype(np.float32)
    noise = canvas.noise(0.7)
    drawn = smeared(noise, ways, length * canvas.unit)
    return drawn / max(float(drawn.std()), 1e-6)
