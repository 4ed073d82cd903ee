"""What is behind people in pictures."""

import cv2
import numpy as np


def random_background(size: int, generator: np.random.Generator) -> np.ndarray:
    """Draw paper, one colour, a gradient, clouds, or a mess of shapes. Returns (size, size, 3) linear light."""
    kind = generator.random()
    base = random_colour(generator)
    if kind < 0.15:
        paper = np.full(3, generator.uniform(0.7, 1.0)) if generator.random() < 0.7 else base
        return np.broadcast_to(paper, (size, size, 3)).astype(np.float32)
    if kind < 0.3:
        return np.broadcast_to(base, (size, size, 3)).astype(np.float32)
    image = _gradient(size, base, generator)
    for _ in range(generator.integers(0, 4)):
        clouds = blob_noise(size, float(generator.choice([0.03, 0.08, 0.2, 0.4])), generator)
        image = image + clouds[..., None] * (generator.normal(0, 0.08) + generator.normal(0, 0.04, 3)).astype(
            np.float32
        )
    image = np.clip(image, 0, 1).astype(np.float32)
    if kind > 0.5:
        # Letters can be drawn in whole numbers alone.
        levels = np.ascontiguousarray(np.round(255 * image), np.uint8)
        _clutter(levels, int(generator.integers(2, 14)), generator)
        image = levels.astype(np.float32) / 255
    if generator.random() < 0.3:
        image = cv2.GaussianBlur(image, (0, 0), float(generator.uniform(0.005, 0.04)) * size)
    return image


def random_colour(generator: np.random.Generator) -> np.ndarray:
    """(3,) linear light of any hue, more often dull than gaudy."""
    hue = generator.random() + np.array([0, 2, 1]) / 3
    pure = np.clip(np.abs(6 * (hue % 1) - 3) - 1, 0, 1)
    saturation = generator.beta(1.2, 1.8)
    value = generator.beta(1.6, 1.2)
    return (value * (1 - saturation * (1 - pure))) ** 2.2


def blob_noise(size: int, scale: float, generator: np.random.Generator) -> np.ndarray:
    """(size, size) float32 of smooth noise with a deviation near 1. scale: of its blobs, shares of the side."""
    cells = max(2, round(1 / scale))
    coarse = generator.normal(size=(cells, cells)).astype(np.float32)
    return cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC)


def _gradient(size: int, base: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    rows, columns = np.mgrid[:size, :size] / size - 0.5
    turn = generator.uniform(0, 2 * np.pi)
    share = np.clip(columns * np.cos(turn) + rows * np.sin(turn) + 0.5, 0, 1)[..., None]
    return (base * (1 - share) + random_colour(generator) * share).astype(np.float32)


def _clutter(image: np.ndarray, count: int, generator: np.random.Generator) -> None:
    """Draw shapes of any kind into a picture."""
    size = len(image)
    for _ in range(count):
        colour = tuple(255 * float(value) for value in random_colour(generator))
        place = tuple(int(value) for value in generator.integers(0, size, 2))
        kind = generator.random()
        if kind < 0.35:
            axes = tuple(int(value) for value in generator.integers(2, [size // 3, size // 4]))
            cv2.ellipse(image, place, axes, float(generator.uniform(0, 180)), 0, 360, colour, -1, cv2.LINE_AA)
        elif kind < 0.6:
            corners = np.array(place) + generator.normal(0, 0.18 * size, (int(generator.integers(3, 7)), 2))
            cv2.fillPoly(image, [np.round(corners).astype(np.int32)], colour, cv2.LINE_AA)
        elif kind < 0.85:
            end = tuple(int(value) for value in generator.integers(0, size, 2))
            cv2.line(image, place, end, colour, int(generator.integers(1, max(2, size // 20))), cv2.LINE_AA)
        else:
            letters = "".join(chr(code) for code in generator.integers(65, 91, generator.integers(2, 9)))
            cv2.putText(
                image, letters, place, int(generator.integers(0, 8)), size / 300, colour,
                int(generator.integers(1, 4)), cv2.LINE_AA,
            )  # fmt: skip
