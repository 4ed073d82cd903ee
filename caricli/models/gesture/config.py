"""Settings of the gesture network and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_ranges, check_windows

POOLED = 8
"""Places of the first layer, along a side, that pooling makes one."""

_RANGES = TRAINING_RANGES | {"size": (16, 512), "stride": (1, 8), "batch": (1, 4096), "others": (0, 0.9)}


@dataclass(frozen=True)
class GestureConfig(NetworkTraining):
    """Settings of a gesture network's training: NetworkTraining's and its own.

    Its windows are pictures that a stroke is drawn into, the paper's of 256 pixels; validation: strokes of each of the
    gestures. stride: of the first layer, pixels. others: share of strokes that are no gesture, of which the network is
    to say that it could be any.
    Raises ValueError for impossible sizes.
    """

    size: int = 64
    epochs: int = 18
    steps: int = 250
    batch: int = 64
    weight_decay: float = 5e-4
    decay: float = 0.995
    validation: int = 100
    validate_every: int = 2
    stride: int = 2
    others: float = 0.15

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, POOLED * self.stride, self.precision)
