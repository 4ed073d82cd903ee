"""The picture on an eyeball."""

import numpy as np

IRIS, PUPIL = 0.078, 0.032
"""Radii, as shares of the picture's width, which spans the ball from pole to pole."""

_WHITE, _VEINED = (236, 231, 224), (214, 178, 164)
_RIM, _OUTER, _INNER = (38, 24, 16), (104, 68, 40), (150, 108, 66)
_EDGE = 0.006


def paint_eye(size, generator, iris=None, white=None):
    """Paint sclera, iris and pupil for UVs that unroll a ball from its front, at the middle.

    size: pixels, width and height. generator: numpy Generator, of the fibres of the iris. iris, white: (3,)
    sRGB, 0 to 255, or None for the usual ones.
    Returns (size, size, 3) uint8 sRGB.
    """
    y, x = (np.mgrid[:size, :size] + 0.5) / size - 0.5
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    waves = sum(a * np.cos(n * angle + p) for n, a, p in zip(
        generator.integers(20, 90, 24), generator.uniform(0, 1, 24), generator.uniform(0, 2 * np.pi, 24), strict=True
    ))  # fmt: skip
    white, veined = _tinted(white, _WHITE, _VEINED)
    inner, outer, rim = _tinted(iris, _INNER, _OUTER, _RIM)
    picture = _mix(white, veined, _step(radius, 0.11, 0.25))
    depth = _step(radius, PUPIL, IRIS)[..., None]
    iris = (1 - depth) * inner + depth * outer
    iris *= 1 + 0.05 * waves[..., None] / np.sqrt(12)
    iris = _mix(iris, rim, _step(radius, 0.78 * IRIS, IRIS))
    picture = _mix(iris, picture, _step(radius, IRIS - _EDGE / 2, IRIS + _EDGE / 2))
    picture = _mix(np.full(3, 8.0), picture, _step(radius, PUPIL - _EDGE / 2, PUPIL + _EDGE / 2))
    # A light that stays, because the engines' own reflections hardly show on small eyes.
    glint = _step(np.hypot(x + 0.024, y + 0.028), 0.014, 0.007)
    return np.clip(np.round(_mix(picture, np.full(3, 250.0), 0.9 * glint)), 0, 255).astype(np.uint8)


def _tinted(colour, *usual):
    """The usual colours, scaled so that the first becomes another where one is given."""
    usual = np.array(usual, float)
    return usual if colour is None else np.clip(usual * (np.asarray(colour, float) / usual[0]), 0, 255)


def _step(value, start, end):
    """0 before the start, 1 after the end, smooth between them."""
    t = np.clip((value - start) / (end - start), 0, 1)
    return t * t * (3 - 2 * t)


def _mix(first, second, share):
    return first + share[..., None] * (second - first)
