"""Pictures made to look as if they had been drawn, printed, photographed badly or covered: what augments a training."""

from collections.abc import Callable

import numpy as np

from caricli.structures.detection import MarkedPicture
from caricli.structures.parsing import Region

_GREY = np.array([0.299, 0.587, 0.114], np.float32)


def disguise_window(window: MarkedPicture, generator: np.random.Generator) -> MarkedPicture:
    """Cover a part of a window, change its colours, draw it with other means, spoil it; each with some chance.

    Returns a window with pixels (H, W, 3) float32 from 0 to 1.
    """
    if generator.random() < 0.15:
        window = _covered(window, generator)
    image = window.pixels.astype(np.float32) / 255
    for chance, change in _CHANGES:
        if generator.random() < chance:
            image = change(image, generator)
    return MarkedPicture(np.clip(image, 0, 1), window.regions, window.landmarks, window.visible)


def _covered(window: MarkedPicture, generator: np.random.Generator) -> MarkedPicture:
    """With an ellipse or a bar of one colour in front."""
    import cv2

    size = len(window.regions)
    cover = np.zeros((size, size), np.uint8)
    centre = generator.integers(0, size, 2)
    if generator.random() < 0.6:
        axes = generator.integers(size // 24, size // 5, 2)
        cv2.ellipse(cover, centre.tolist(), axes.tolist(), generator.uniform(0, 180), 0, 360, 1, cv2.FILLED)
    else:
        end = generator.integers(0, size, 2)
        cv2.line(cover, centre.tolist(), end.tolist(), 1, int(generator.integers(2, size // 8)))
    hidden = cover.astype(bool)
    pixels = np.where(hidden[..., None], generator.integers(0, 256, 3), window.pixels).astype(np.uint8)
    cells = np.clip(np.rint(window.landmarks), 0, size - 1).astype(int)
    visible = window.visible & ~hidden[cells[..., 1], cells[..., 0]]
    regions = np.where(hidden, np.uint8(Region.OTHER), window.regions)
    return MarkedPicture(pixels, regions, window.landmarks, visible)


def _grey(image: np.ndarray) -> np.ndarray:
    return np.clip(image @ _GREY, 0, 1)


def _blur(image: np.ndarray, deviation: float) -> np.ndarray:
    import cv2

    return cv2.GaussianBlur(image, (0, 0), deviation)


def _painted(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """In patches of one colour, as a brush leaves them."""
    import cv2

    if generator.random() < 0.6:
        size = int(generator.choice([3, 5]))
        return cv2.medianBlur(np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8), size).astype(np.float32) / 255
    return cv2.bilateralFilter(np.ascontiguousarray(image), 5, 0.15, 3)


def _blurred(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    return _blur(image, generator.uniform(0.5, 1.6))


def _posterised(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """In a few tones, of every colour or of the brightness."""
    tones = int(generator.integers(3, 9))
    if generator.random() < 0.5:
        return np.round(image * tones) / tones
    grey = _grey(image)
    return image * (np.round(grey * tones) / tones / np.maximum(grey, 0.02))[..., None]


def _mixed(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """In colours that are mixed from one another."""
    mix = np.eye(3) + 0.18 * generator.normal(size=(3, 3))
    return image @ (mix / mix.sum(1, keepdims=True)).T.astype(np.float32)


def _saturated(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    grey = _grey(image)[..., None]
    return grey + (image - grey) * np.float32(generator.uniform(0, 1.8))


def _monochrome(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    tint = generator.uniform(0.75, 1.1, 3) if generator.random() < 0.5 else np.ones(3)
    return _grey(image)[..., None] * tint.astype(np.float32)


def _lit(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Brighter or darker, with more or less contrast."""
    image = np.clip(image, 0, 1) ** np.float32(np.exp(0.3 * generator.normal()))
    contrast = np.exp(0.25 * generator.normal())
    return ((image - 0.5) * contrast + 0.5 + 0.08 * generator.normal()).astype(np.float32)


def _lined(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """With dark lines where brightness changes, over the colours or on paper (difference of Gaussians)."""
    grey = _grey(image)
    width = generator.uniform(0.5, 1.3)
    change = _blur(grey, width) - generator.uniform(0.93, 1) * _blur(grey, 1.6 * width)
    dark = np.minimum(change + generator.uniform(-0.005, 0.01), 0) * generator.uniform(15, 80)
    line = np.clip(1 + np.tanh(dark), 0, 1)[..., None].astype(np.float32)
    if generator.random() < 0.6:
        return image * (1 - np.float32(generator.uniform(0.3, 1)) * (1 - line))
    paper = generator.uniform(0.75, 1, 3) if generator.random() < 0.5 else np.ones(3)
    shade = 1 - np.float32(generator.uniform(0, 0.5)) * (1 - grey[..., None])
    return line * paper.astype(np.float32) * shade


def _pencilled(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Grey strokes on white: brightness divided by that of the neighbourhood."""
    grey = _grey(image)
    ratio = grey / np.maximum(_blur(grey, generator.uniform(2, 6)), 0.05)
    return np.repeat((np.clip(ratio, 0, 1) ** np.float32(generator.uniform(1, 4)))[..., None], 3, 2)


def _drawn(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    return _lined(image, generator) if generator.random() < 0.65 else _pencilled(image, generator)


def _noisy(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """With grain, fine or coarse, of brightness or colour."""
    import cv2

    size = len(image)
    cells = size // int(generator.integers(1, 4))
    channels = int(generator.choice([1, 3]))
    grain = generator.standard_normal((cells, cells, channels), np.float32)
    coarse = cv2.resize(grain, (size, size)).reshape(size, size, channels)
    return image + np.float32(generator.uniform(0.01, 0.1)) * coarse


def _shrunk(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """As enlarged from a smaller picture."""
    import cv2

    size = len(image)
    smaller = round(size * generator.uniform(0.35, 0.8))
    small = cv2.resize(image, (smaller, smaller), interpolation=cv2.INTER_AREA)
    return cv2.resize(small, (size, size))


def _compressed(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """As stored in few bytes."""
    import cv2

    whole = np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
    data = cv2.imencode(".jpg", whole, [cv2.IMWRITE_JPEG_QUALITY, int(generator.integers(15, 80))])[1]
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.float32) / 255


def _inverted(image: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    return 1 - image


_CHANGES: list[tuple[float, Callable[[np.ndarray, np.random.Generator], np.ndarray]]] = [
    (0.15, _painted),
    (0.08, _blurred),
    (0.15, _posterised),
    (0.5, _mixed),
    (0.3, _saturated),
    (0.18, _monochrome),
    (0.9, _lit),
    (0.45, _drawn),
    (0.3, _noisy),
    (0.2, _shrunk),
    (0.15, _compressed),
    (0.01, _inverted),
]
"""What is done to a window, one after the other, each with its chance."""
