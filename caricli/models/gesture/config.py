"""Settings of the gesture network and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_SEED, check_ranges, check_windows

POOLED = 8
"""Places of the first layer, along a side, that pooling makes one."""

_RANGES = {
    "size": (16, 512), "stride": (1, 8), "epochs": (1, 10**6), "steps": (1, 10**6), "batch": (1, 4096),
    "learning_rate": (1e-9, 1), "weight_decay": (0, 10), "decay": (0, 0.99999), "others": (0, 0.9),
    "validation": (1, 10**5), "validate_every": (1, 10**6), "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip


@dataclass(frozen=True)
class GestureConfig:
    """Settings of a gesture network's training.

    size: of the picture that a stroke is drawn into, pixels; the paper's are 256. stride: of the first layer, pixels.
    epochs; steps: in an epoch; batch: strokes a step. learning_rate, weight_decay: of AdamW, with a cosine schedule.
    decay: of the weights' moving average, a step. precision: of the convolutions. others: share of strokes that are no
    gesture, of which the network is to say that it could be any. validation: strokes of each gesture to validate with.
    validate_every: epochs. checkpoint_seconds: between two checkpoints.
    Raises ValueError for impossible sizes.
    """

    size: int = 64
    stride: int = 2
    epochs: int = 18
    steps: int = 250
    batch: int = 64
    learning_rate: float = 1e-3
    weight_decay: float = 5e-4
    decay: float = 0.995
    precision: str = "bfloat16"
    others: float = 0.15
    validation: int = 100
    validate_every: int = 2
    checkpoint_seconds: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, POOLED * self.stride, self.precision)
