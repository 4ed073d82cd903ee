"""Settings of the network that sees faces in sketches, and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_SEED, check_ranges, check_windows

_SIZES = {"stem": (4, 512), "hidden": (1, 8192), "told": (1, 8192)}
_RANGES = _SIZES | {
    "size": (64, 512), "epochs": (1, 10**6), "steps": (1, 10**6), "batch": (2, 4096), "mixed": (0, 1),
    "people": (1, 64), "missing": (0, 1), "unnamed": (0, 1), "strength": (0, 10), "learning_rate": (1e-9, 1),
    "weight_decay": (0, 10), "decay": (0, 0.99999), "camera_weight": (0, 1e6), "validation": (1, 10**5),
    "validate_every": (1, 10**6), "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip
_STEP = 32
"""Pixels that the network reduces to one: a window has a multiple of them."""

_LEVELS = 3


@dataclass(frozen=True)
class SketchSize:
    """Size of the network.

    stem: channels at a quarter of the window's size. widths, blocks: channels and residual blocks at 1/8, 1/16 and 1/32
    of it. told: width of the two layers for points along strokes. hidden: numbers between what is seen and the latent.
    Raises ValueError for impossible sizes.
    """

    stem: int = 32
    widths: tuple[int, ...] = (64, 96, 128)
    blocks: tuple[int, ...] = (0, 1, 1)
    told: int = 384
    hidden: int = 512

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)
        for name, limits in (("widths", (4, 4096)), ("blocks", (0, 64))):
            values = getattr(self, name)
            if len(values) != _LEVELS or not all(limits[0] <= value <= limits[1] for value in values):
                raise ValueError(f"{name} must be {_LEVELS} numbers from {limits[0]} to {limits[1]}, found {values}")


@dataclass(frozen=True)
class SketchConfig:
    """Settings of a sketch network's training.

    With the defaults the network has 5.3 MB in half precision.

    stem, widths, blocks, told, hidden: see SketchSize. size: of the windows, pixels; a multiple of 32. epochs; steps:
    in an epoch. batch: sketches a step. mixed: share of them that are of nobody, mixtures of ``people`` at most with
    the expression of one face. missing: share of the sketches that lack strokes, up to all but a few. unnamed: share of
    which only the picture is given. strength: of the noise of hand and view on average, 1 as ``HandSettings`` has it;
    every sketch has its own, from none to twice as much. learning_rate, weight_decay: of AdamW, with a cosine schedule.
    decay: of the weights' moving average, a step. camera_weight: of the squared error of the camera beside the mean
    distance of the vertices, percent of the head's height. precision: of the convolutions. validation: sketches
    measured at a validation. validate_every: epochs. checkpoint_seconds: between two checkpoints.
    Raises ValueError for impossible sizes.
    """

    stem: int = 32
    widths: tuple[int, ...] = (64, 96, 128)
    blocks: tuple[int, ...] = (0, 1, 1)
    told: int = 384
    hidden: int = 512
    size: int = 128
    epochs: int = 100
    steps: int = 50
    batch: int = 64
    mixed: float = 0.5
    people: int = 5
    missing: float = 0.5
    unnamed: float = 0.2
    strength: float = 1.0
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2
    decay: float = 0.998
    camera_weight: float = 0.05
    precision: str = "bfloat16"
    validation: int = 200
    validate_every: int = 5
    checkpoint_seconds: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        self.network()
        check_windows(self.size, _STEP, self.precision)

    def network(self) -> SketchSize:
        """The SketchSize."""
        return SketchSize(self.stem, self.widths, self.blocks, self.told, self.hidden)
