"""Settings of the network that tells what strokes draw, and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_levels, check_ranges, check_windows, size_in

STEP = 32
"""Pixels that the network reduces to one: a window has a multiple of them."""

_LEVELS = 4
_SIZES = {"patch": (3, 31), "told": (4, 2048)}
_RANGES = TRAINING_RANGES | _SIZES | {"points": (1, 10**4), "strength": (0, 10), "missing": (0, 1)}


@dataclass(frozen=True)
class StrokeSize:
    """Size of the network.

    widths, blocks: channels and residual blocks at 1/4, 1/8, 1/16 and 1/32 of the window's size. patch: pixels around a
    place, along a side, that are looked at as they are; odd. told: width of the layers for a place.
    Raises ValueError for impossible sizes.
    """

    widths: tuple[int, ...] = (64, 96, 128, 128)
    blocks: tuple[int, ...] = (1, 2, 2, 1)
    patch: int = 11
    told: int = 128

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)
        check_levels(self, _LEVELS)
        if self.patch % 2 == 0:
            raise ValueError(f"patch must be odd, found {self.patch}")


@dataclass(frozen=True)
class StrokesConfig(StrokeSize, NetworkTraining):
    """Settings of the training: NetworkTraining's, those of StrokeSize, and its own.

    With the defaults the network has 3.9 MB in half precision. points: along the strokes of a sketch that count in a
    step. strength: of the hand on average, 1 as ``HandSettings`` has it; every sketch has its own, from none to twice
    as much. missing: share of the sketches that lack strokes, up to all but a few.
    Raises ValueError for impossible sizes.
    """

    epochs: int = 36
    learning_rate: float = 4e-3
    weight_decay: float = 1e-2
    decay: float = 0.99
    points: int = 384
    strength: float = 0.9
    missing: float = 0.3

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        self.network()
        check_windows(self.size, STEP, self.precision)

    def network(self) -> StrokeSize:
        """The size of the network."""
        return size_in(self, StrokeSize)
