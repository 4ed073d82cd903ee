"""What a face wears."""

from dataclasses import dataclass

import numpy as np

from caricli.structures.checks import refuse


@dataclass(frozen=True, eq=False)
class Pictures:
    """What is on a face. skin, eyes: (H, W, 3) uint8 sRGB, the top row first, or None.

    Raises InputError when a picture has another shape or type.
    """

    skin: np.ndarray | None = None
    eyes: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check both."""
        for name in ("skin", "eyes"):
            if getattr(self, name) is not None:
                refuse(picture_problem(name, np.asarray(getattr(self, name))))

    def __bool__(self) -> bool:
        """Whether there is any."""
        return self.skin is not None or self.eyes is not None

    def same(self, other: "Pictures") -> bool:
        """Whether these are like others, texel by texel."""
        return _same(self.skin, other.skin) and _same(self.eyes, other.eyes)

    def mixed(self, other: "Pictures", weight: float) -> "Pictures":
        """Between these and others, which have a weight from 0 to 1: their mean where both have one of the same size,
        else that of the nearer.
        """
        return Pictures(_mixed(self.skin, other.skin, weight), _mixed(self.eyes, other.eyes, weight))


def picture_problem(key: str, image: np.ndarray) -> str | None:
    """What is wrong with a picture of a name, or None."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
        return f"{key}: expected (H,W,3) uint8, found {image.shape} {image.dtype}"
    return None


def _same(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    if first is None or second is None:
        return first is second
    return first is second or np.array_equal(first, second)


def _mixed(first: np.ndarray | None, second: np.ndarray | None, weight: float) -> np.ndarray | None:
    if first is None or second is None:
        return second if first is None else first
    if first.shape != second.shape or _same(first, second):
        return first if weight < 0.5 else second
    mean = np.multiply(first, 1 - weight, dtype=np.float32) + np.multiply(second, weight, dtype=np.float32)
    return np.rint(mean).astype(np.uint8)
