"""Settings of the style network and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_SEED, check_ranges, check_windows

STEP = 4
"""Pixels that the encoder reduces to one."""

ENCODERS = ("learnt", "random")
"""How encoders come to be."""

_RANGES = {
    "width": (4, 256), "size": (16, 512), "pictures": (2, 10**5), "epochs": (1, 10**6), "steps": (1, 10**6),
    "batch": (2, 4096), "learning_rate": (1e-9, 1), "weight_decay": (0, 10), "decay": (0, 0.99999),
    "content_weight": (0, 1e6), "style_weight": (0, 1e6), "again_weight": (0, 1e6), "pair_weight": (0, 1e6),
    "medium_weight": (0, 1e6), "validation": (1, 10**5), "validate_every": (1, 10**6),
    "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip


@dataclass(frozen=True)
class StyleConfig:
    """Settings of a style network's training.

    width: channels at full size; there are two and four times as many at a half and a quarter. encoder: learnt, or
    random and left so, for comparison. size: of the windows, pixels. pictures: generated faces to train on, each plain,
    painted, and painted alike in another light. epochs; steps: in an epoch; batch: windows a step. learning_rate,
    weight_decay: of AdamW, with a cosine schedule. decay: of the weights' moving average, a step. Weights of the
    losses: content_weight of features, style_weight of their means and deviations, again_weight of a picture decoded as
    it is, pair_weight of what the true painting is like, medium_weight of telling media apart. precision: of the
    convolutions. validation: further faces to validate with. validate_every: epochs. checkpoint_seconds: between two
    checkpoints.
    Raises ValueError for impossible sizes.
    """

    width: int = 32
    encoder: str = "learnt"
    size: int = 64
    pictures: int = 600
    epochs: int = 40
    steps: int = 100
    batch: int = 8
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    decay: float = 0.995
    content_weight: float = 0.5
    style_weight: float = 2.0
    again_weight: float = 10.0
    pair_weight: float = 10.0
    medium_weight: float = 0.1
    precision: str = "bfloat16"
    validation: int = 48
    validate_every: int = 4
    checkpoint_seconds: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, STEP, self.precision)
        if self.encoder not in ENCODERS:
            raise ValueError(f"encoder must be {' or '.join(ENCODERS)}, found {self.encoder!r}")
