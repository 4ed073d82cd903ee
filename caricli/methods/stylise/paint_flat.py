"""Flat colours and lines, as in a cartoon."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.stylise.canvas import Canvas, step
from caricli.methods.stylise.flow import flow, lines
from caricli.render.pixels.levels import saturated, to_bytes, to_floats

_INK = np.array([0.12, 0.08, 0.1], np.float32)


@dataclass(frozen=True)
class FlatSettings:
    """Areas and lines; lengths in units.

    area: radius of what becomes one colour, alike: levels of 255 that colours in it differ by. steps: of light from
    black to white, and soft: width of their edges, of one step. saturation: of the colours. line: width of lines, and
    depth: contrast, 0 to 1, from which on they are black.
    """

    area: float = 2.0
    alike: float = 26.0
    steps: float = 7.0
    soft: float = 0.25
    saturation: float = 1.4
    line: float = 1.0
    depth: float = 0.09


def paint_flat(canvas: Canvas, settings: FlatSettings = FlatSettings()) -> np.ndarray:  # noqa: B008 (frozen)
    """Paint areas of one colour each, in steps of light, with lines between (Winnemoeller, Olsen and Gooch 2006).

    Returns (H, W, 3) float32.
    """
    radius = max(2.0, settings.area * canvas.unit)
    levels = cv2.pyrMeanShiftFiltering(to_bytes(canvas.image), radius, settings.alike, maxLevel=1)
    side = 2 * max(1, round(0.35 * radius)) + 1
    smooth = cv2.medianBlur(levels, side)
    lab = cv2.cvtColor(to_floats(smooth), cv2.COLOR_RGB2Lab)
    light = lab[..., 0] * settings.steps / 100
    floor = np.floor(light)
    lab[..., 0] = (floor + step(light - floor - 0.5, settings.soft)) * 100 / settings.steps
    colours = saturated(np.clip(cv2.cvtColor(lab, cv2.COLOR_Lab2RGB), 0, 1), settings.saturation)
    ink = step(lines(canvas, flow(canvas, 1.5), settings.line, settings.depth) - 0.5, 0.5)[..., None]
    return colours + 0.9 * ink * (_INK - colours)
