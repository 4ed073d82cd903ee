"""Settings of the style network and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_ranges, check_windows

STEP = 4
"""Pixels that the encoder reduces to one."""

ENCODERS = ("learnt", "random")
"""How encoders come to be."""

_RANGES = TRAINING_RANGES | {
    "width": (4, 256), "size": (16, 512), "pictures": (2, 10**5), "content_weight": (0, 1e6), "style_weight": (0, 1e6),
    "again_weight": (0, 1e6), "pair_weight": (0, 1e6), "medium_weight": (0, 1e6),
}  # fmt: skip


@dataclass(frozen=True)
class StyleConfig(NetworkTraining):
    """Settings of a style network's training: NetworkTraining's and its own.

    width: channels at full size; there are two and four times as many at a half and a quarter. encoder: learnt, or
    random and left so, for comparison. pictures: generated faces to train on, each plain, painted, and painted alike in
    another light; those to validate with are further ones. Weights of the losses: content_weight of features,
    style_weight of their means and deviations, again_weight of a picture decoded as it is, pair_weight of what the true
    painting is like, medium_weight of telling media apart.
    Raises ValueError for impossible sizes.
    """

    size: int = 64
    batch: int = 8
    weight_decay: float = 1e-4
    decay: float = 0.995
    validation: int = 48
    validate_every: int = 4
    width: int = 32
    encoder: str = "learnt"
    pictures: int = 600
    content_weight: float = 0.5
    style_weight: float = 2.0
    again_weight: float = 10.0
    pair_weight: float = 10.0
    medium_weight: float = 0.1

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, STEP, self.precision)
        if self.encoder not in ENCODERS:
            raise ValueError(f"encoder must be {' or '.join(ENCODERS)}, found {self.encoder!r}")
