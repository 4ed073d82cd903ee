"""The picture on an eyeball."""

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.render.pixels.paint import mix

IRIS = 0.078
PUPIL = 0.032
"""Radii, as shares of the picture's width, which spans the ball from pole to pole."""

_EDGE = 0.006  # of the width: how soft the borders of iris and pupil are
_VEINS = (0.11, 0.25)  # of the width: from where to where the white turns reddish
_RIM_START = 0.78  # of the iris: from there on it darkens
_FIBRES = 24
_FINENESS = (20, 90)  # waves around the iris, least and one more than most
_CONTRAST = 0.05  # of the iris' brightness
_GLINT = (0.024, 0.028)  # of the width, left of the middle and above it
_GLINT_RADII = (0.014, 0.007)  # of the width, where it ends and where it is full
_GLINT_STRENGTH = 0.9

# sRGB, 0 to 255.
_WHITE = (236, 231, 224)
_VEINED = (214, 178, 164)
_RIM = (38, 24, 16)
_OUTER = (104, 68, 40)
_INNER = (150, 108, 66)
_IRIS = (127, 88, 53)  # what is half-way between them, and what is seen of an iris
_BLACK = 8.0
_LIGHT = 250.0


def paint_eye(
    size: int,
    generator: np.random.Generator,
    iris: np.ndarray | None = None,
    white: np.ndarray | None = None,
    reach: float = IRIS,
) -> np.ndarray:
    """Paint sclera, iris and pupil for UVs that unroll a ball from its front, at the middle.

    size: pixels, width and height. generator: numpy Generator, of the fibres of the iris. iris, white: (3,)
    sRGB, 0 to 255, or None for the usual ones. reach: of the iris, a share of the width; the pupil goes with it.
    Returns (size, size, 3) uint8 sRGB.
    """
    y, x = (np.mgrid[:size, :size] + 0.5) / size - 0.5
    radius = np.hypot(x, y)
    pupil = PUPIL / IRIS * reach
    waves = np.zeros_like(radius)
    # The rest of the picture has none, and they take most of the time.
    fibrous = radius < reach + _EDGE
    waves[fibrous] = _waves(np.arctan2(y[fibrous], x[fibrous]), generator)
    sclera, veined = _tinted(white, _WHITE, _WHITE, _VEINED)
    inner, outer, rim = _tinted(iris, _IRIS, _INNER, _OUTER, _RIM)
    picture = mix(sclera, veined, smooth_step(radius, *_VEINS))
    depth = smooth_step(radius, pupil, reach)[..., None]
    fibres = (1 - depth) * inner + depth * outer
    fibres *= 1 + _CONTRAST * waves[..., None] / np.sqrt(_FIBRES / 2)
    fibres = mix(fibres, rim, smooth_step(radius, _RIM_START * reach, reach))
    picture = mix(fibres, picture, smooth_step(radius, reach - _EDGE / 2, reach + _EDGE / 2))
    picture = mix(np.full(3, _BLACK), picture, smooth_step(radius, pupil - _EDGE / 2, pupil + _EDGE / 2))
    # A light that stays, because the engines' own reflections hardly show on small eyes.
    glint = smooth_step(np.hypot(x + _GLINT[0], y + _GLINT[1]), *_GLINT_RADII)
    picture = mix(picture, np.full(3, _LIGHT), _GLINT_STRENGTH * glint)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def _waves(angle: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Random waves around the iris, the sum of a few dozen of them. angle: (N,) radians."""
    counts = generator.integers(*_FINENESS, _FIBRES)
    strengths = generator.uniform(0, 1, _FIBRES)
    phases = generator.uniform(0, 2 * np.pi, _FIBRES)
    waves = np.zeros_like(angle)
    for count, strength, phase in zip(counts, strengths, phases, strict=True):
        waves += strength * np.cos(count * angle + phase)
    return waves


def _tinted(colour: np.ndarray | None, seen: tuple[int, int, int], *usual: tuple[int, int, int]) -> np.ndarray:
    """The usual colours, scaled so that the one that is seen of them becomes another where one is given."""
    colours = np.array(usual, float)
    return colours if colour is None else np.clip(colours * np.asarray(colour, float) / seen, 0, 255)
