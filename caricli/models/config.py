"""What the settings of all models share."""

from collections.abc import Mapping
from dataclasses import Field, dataclass, fields
from typing import Any, ClassVar, Protocol, TypeVar

MAX_SEED = 2**32 - 1
MAX_DIMENSION = 4096
"""Largest latent: far above what shapes can fill."""
_PRECISIONS = ("float32", "bfloat16")
Size = TypeVar("Size")


class TrainingConfig(Protocol):
    """Settings of a training: a frozen dataclass with a seed, whose every field has a default."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def seed(self) -> int:
        """Of everything random in the training; it goes into the recipe."""


@dataclass(frozen=True)
class LinearConfig:
    """Settings of a model of principal components.

    dimension: of the latent; 128 is the size of the deformable paper's. seed: of the randomised decomposition.
    Raises ValueError for impossible sizes.
    """

    dimension: int = 128
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, {"dimension": (1, MAX_DIMENSION), "seed": (0, MAX_SEED)})


TRAINING_RANGES = {
    "size": (64, 512), "epochs": (1, 10**6), "steps": (1, 10**6), "batch": (2, 4096), "learning_rate": (1e-9, 1),
    "weight_decay": (0, 10), "decay": (0, 0.99999), "validation": (1, 10**5), "validate_every": (1, 10**6),
    "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip
"""Of NetworkTraining; a network may have narrower or wider ones."""


@dataclass(frozen=True)
class NetworkTraining:
    """What the trainings of all networks share that look at pictures.

    size: of the windows that the network is trained on, pixels; a multiple of what it reduces to one. epochs; steps: in
    an epoch; batch: windows a step. learning_rate, weight_decay: of AdamW, with a cosine schedule. decay: of the
    weights' moving average, a step. precision: of the convolutions. validation: faces measured at a validation.
    validate_every: epochs. checkpoint_seconds: between two checkpoints. seed: of everything random.
    """

    size: int = 128
    epochs: int = 40
    steps: int = 100
    batch: int = 32
    learning_rate: float = 1e-3
    weight_decay: float = 1e-3
    decay: float = 0.998
    precision: str = "bfloat16"
    validation: int = 200
    validate_every: int = 5
    checkpoint_seconds: int = 60
    seed: int = 0


def size_in(config: object, kind: type[Size]) -> Size:
    """The size of a network that settings name among others. kind: its dataclass. Raises ValueError as that does."""
    return kind(**{each.name: getattr(config, each.name) for each in fields(kind)})  # type: ignore[arg-type]


def check_ranges(config: object, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Refuse settings out of their range. ranges: names to (low, high). Raises ValueError."""
    for name, (low, high) in ranges.items():
        value = getattr(config, name)
        if not low <= value <= high:
            raise ValueError(f"{name} must be from {low:g} to {high:g}, found {value}")


def check_levels(config: object, count: int) -> None:
    """Refuse ``widths`` and ``blocks`` that are not for so many levels of an encoder. Raises ValueError."""
    for name, (low, high) in (("widths", (4, 4096)), ("blocks", (0, 64))):
        values = getattr(config, name)
        if len(values) != count or not all(low <= value <= high for value in values):
            raise ValueError(f"{name} must be {count} numbers from {low} to {high}, found {values}")


def check_windows(size: int, step: int, precision: str) -> None:
    """Refuse windows that a network cannot take.

    size: pixels. step: pixels that the network reduces to one. precision: of its convolutions. Raises ValueError.
    """
    if size % step:
        raise ValueError(f"size must be a multiple of {step}, found {size}")
    if precision not in _PRECISIONS:
        raise ValueError(f"precision must be {' or '.join(_PRECISIONS)}, found {precision!r}")
