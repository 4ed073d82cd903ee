"""What pictures are made with: a camera, paint, ink, pencil, print."""

from collections.abc import Callable

import cv2
import numpy as np

from caricli.methods.pictures.background import blob_noise
from caricli.render.pixels.levels import saturated, to_bytes, to_floats


def photograph(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """A photograph: a little blur, grain, a vignette, a tone of its own."""
    size = len(image)
    if generator.random() < 0.3:
        image = cv2.GaussianBlur(image, (0, 0), generator.uniform(0.3, 1.6))
    grain = generator.normal(0, generator.uniform(0, 0.05), (size, size, int(generator.choice([1, 3]))))
    image = image ** generator.uniform(0.75, 1.3) * (1 + generator.normal(0, 0.04, 3)) + grain
    if generator.random() < 0.15:
        image = np.repeat(image.mean(2, keepdims=True), 3, 2) * (1 + generator.normal(0, 0.03, 3))
    rows, columns = np.mgrid[:size, :size] / size - 0.5
    return image * (1 - generator.uniform(0, 0.6) * (rows**2 + columns**2))[..., None]


def painted(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Paint: colours run together in strokes, on canvas or paper."""
    size = len(image)
    levels = to_bytes(image)
    if generator.random() < 0.5:
        levels = cv2.pyrMeanShiftFiltering(levels, size / 60, generator.uniform(12, 32), maxLevel=1)
    else:
        side = 2 * int(generator.integers(1, max(2, size // 90) + 1)) + 1
        levels = cv2.medianBlur(levels, side)
        levels = cv2.bilateralFilter(levels, 5, 40, 4)
    image = to_floats(levels)
    wobble = generator.uniform(0.2, 1.6)
    image = _displaced(image, wobble * size / 256, 0.03, generator)
    strokes = blob_noise(size, 0.02, generator)[..., None] * generator.uniform(0, 0.05)
    weave = generator.normal(0, generator.uniform(0, 0.03), (size, size, 1))
    return saturated(image + strokes + weave, generator.uniform(0.9, 1.7))


def inked(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Ink lines and solid blacks on paper, with flat colours or without."""
    lines = _lines(image, region, generator)
    paper = np.full_like(image, generator.uniform(0.85, 1.0))
    if generator.random() < 0.5:
        paper = _posterised(image, int(generator.integers(2, 5)), generator) ** generator.uniform(0.4, 0.9)
    if generator.random() < 0.5:
        grey = cv2.GaussianBlur(image.mean(2), (0, 0), 1.2)
        lines = lines * (1 - _step(generator.uniform(0.12, 0.35) - grey, 0.02))
    ink = generator.random(3) * 0.2 if generator.random() < 0.7 else generator.random(3) * 0.5
    return paper * lines[..., None] + ink * (1 - lines[..., None])


def hatched(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Hatching: the darker a place the more ways lines cross in it."""
    size = len(image)
    grey = cv2.GaussianBlur(image.mean(2), (0, 0), size / 200)
    first = generator.uniform(0, np.pi)
    ink = _lines(image, region, generator)
    rows, columns = np.mgrid[:size, :size].astype(np.float32)
    # In a smaller picture finer lines would be none.
    unit = max(size / 256, 1)
    bend = blob_noise(size, 0.2, generator) * 3 * unit
    for level, turn in ((0.62, 0), (0.42, np.pi / 2.3), (0.25, np.pi / 4)):
        phase = columns * np.cos(first + turn) + rows * np.sin(first + turn) + bend
        wave = 0.5 + 0.5 * np.cos(2 * np.pi * phase / (generator.uniform(2.5, 5.5) * unit))
        dark = _step(level - grey, 0.12)
        ink = ink * (1 - generator.uniform(0.5, 0.95) * dark * wave)
    paper = generator.uniform(0.85, 1.0) * (1 + generator.normal(0, 0.03, 3))
    tone = generator.random(3) * 0.3
    return paper * ink[..., None] + tone * (1 - ink[..., None])


def pencil(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Pencil on grained paper, grey or coloured."""
    size = len(image)
    grey = np.clip(image.mean(2), 0, 1)
    inverse = cv2.GaussianBlur(1 - grey, (0, 0), generator.uniform(0.012, 0.05) * size)
    dodge = np.clip(grey / np.maximum(1 - inverse, 0.05), 0, 1)
    share = generator.uniform(0.3, 0.9)
    drawn = dodge ** generator.uniform(1, 3) * (share + (1 - share) * np.clip(grey + 0.2, 0, 1))
    drawn = np.minimum(drawn, 0.3 + 0.7 * _lines(image, region, generator))
    drawn = drawn + (1 - drawn) * generator.normal(0, generator.uniform(0.02, 0.25), (size, size))
    drawn = np.clip(drawn, 0, 1)[..., None]
    paper = generator.uniform(0.85, 1.0) * (1 + generator.normal(0, 0.03, 3))
    colour = saturated(image, 0.8) ** 0.6 if generator.random() < 0.4 else np.ones(3)
    return paper * drawn * colour


def flat(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Flat colours, as in a cartoon, with a line around them or without."""
    image = saturated(_posterised(image, int(generator.integers(3, 7)), generator), generator.uniform(1, 1.8))
    if generator.random() < 0.6:
        lines = _lines(image, region, generator)[..., None]
        image = image * (1 - generator.uniform(0.6, 1.0) * (1 - lines))
    return image


def halftone(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Dots of a print, of three inks or black alone."""
    size = len(image)
    rows, columns = np.mgrid[:size, :size].astype(np.float32)
    cell = generator.uniform(2.2, 4.5) * size / 256
    source = image if generator.random() < 0.6 else np.repeat(image.mean(2, keepdims=True), 3, 2)
    screens = []
    turn = generator.uniform(0, np.pi)
    for channel in range(3):
        angle = turn + channel * (0.26 if source is image else 0)
        u = columns * np.cos(angle) + rows * np.sin(angle)
        v = rows * np.cos(angle) - columns * np.sin(angle)
        screen = 0.5 + 0.25 * (np.cos(2 * np.pi * u / cell) + np.cos(2 * np.pi * v / cell))
        screens.append(_step(source[..., channel] - screen, 0.3))
    share = generator.uniform(0.4, 0.9)
    return (1 - share) * source + share * np.stack(screens, -1)


MEDIA: dict[str, tuple[Callable[[np.ndarray, np.ndarray, np.random.Generator], np.ndarray], float]] = {
    "photograph": (photograph, 0.22),
    "painted": (painted, 0.23),
    "flat": (flat, 0.14),
    "inked": (inked, 0.17),
    "pencil": (pencil, 0.12),
    "hatched": (hatched, 0.06),
    "halftone": (halftone, 0.06),
}
"""What pictures are made with, and how often. Functions of sRGB (S, S, 3) from 0 to 1 and Regions (S, S)."""


def _step(value: np.ndarray, width: float) -> np.ndarray:
    """0 below zero and 1 above, over a width."""
    return np.clip(value / width + 0.5, 0, 1)


def _displaced(image: np.ndarray, pixels: float, scale: float, generator: np.random.Generator) -> np.ndarray:
    """The picture with its borders unsteady by so many pixels."""
    size = len(image)
    rows, columns = np.mgrid[:size, :size].astype(np.float32)
    shift = [pixels * blob_noise(size, scale, generator) for _ in range(2)]
    return cv2.remap(image, columns + shift[0], rows + shift[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _posterised(image: np.ndarray, levels: int, generator: np.random.Generator) -> np.ndarray:
    """The picture in few steps of light, its colours kept."""
    smooth = cv2.bilateralFilter(np.clip(image, 0, 1).astype(np.float32), 7, 0.15, 4)
    light = np.maximum(smooth.max(2, keepdims=True), 1e-3)
    steps = (np.floor(light * levels + generator.uniform(0, 0.5)) + 0.5) / levels
    return np.clip(smooth * np.clip(steps, 0, 1) / light, 0, 1)


def _lines(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """(S, S) 1 on paper, 0 on lines: along borders of regions and where light changes (Winnemöller et al. 2012)."""
    size = len(image)
    width = generator.uniform(0.6, 2.0) * size / 256
    grey = np.clip(image, 0, 1).mean(2).astype(np.float32)
    inner = cv2.GaussianBlur(grey, (0, 0), width)
    outer = cv2.GaussianBlur(grey, (0, 0), 1.6 * width)
    difference = (1 + 18) * inner - 18 * outer
    ink = 1 - np.clip(1 + np.tanh(generator.uniform(4, 10) * (difference - generator.uniform(0.25, 0.5))), 0, 1)
    if generator.random() < 0.7:
        border = cv2.morphologyEx(region, cv2.MORPH_GRADIENT, np.ones((2, 2), np.uint8)) > 0
        ink = np.maximum(ink, np.clip(1.6 * cv2.GaussianBlur(border.astype(np.float32), (0, 0), 0.6 * width), 0, 1))
    if generator.random() < 0.5:
        ink = _displaced(ink, generator.uniform(0.2, 1.2) * size / 256, 0.05, generator)
    return 1 - generator.uniform(0.7, 1.0) * np.clip(ink, 0, 1)
