"""Settings of the detector and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_SEED, check_ranges, check_windows

FINE = 4
"""Pixels a cell of the heat maps."""

COARSE = 16
"""Pixels a cell of the grid on which faces are found."""

HALF = 2
"""Pixels a cell of the map of regions."""

REACH = 64.0
"""Side of a face, pixels, that the grid gives the size 0."""

_RANGES = {
    "stem": (4, 512), "width": (8, 512), "depth": (1, 16), "finer": (0, 16), "size": (64, 512), "epochs": (1, 10**6),
    "steps": (1, 10**6), "rounds": (1, 1000), "batch": (2, 4096), "crops": (0.1, 0.9), "learning_rate": (1e-9, 1),
    "kernel_rate": (1e-9, 1),
    "weight_decay": (0, 10), "decay": (0, 0.99999),
    "heat_weight": (0, 1e6), "place_weight": (0, 1e6), "doubt_weight": (0, 1e6), "visible_weight": (0, 1e6),
    "parsing_weight": (0, 1e6), "face_weight": (0, 1e6), "validation": (1, 10**5), "validate_every": (1, 10**6),
    "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip
STEP = 32
"""Pixels that the network reduces to one: a window has a multiple of them."""


@dataclass(frozen=True)
class DetectorSize:
    """Size of the network.

    stem: channels at half of the window's size. width: channels at a quarter; below it there are 3/2, 2 and 5/2 as
    many. depth: residual blocks at the two lowest levels. finer: residual blocks more at a quarter, at the end.
    Raises ValueError for impossible sizes.
    """

    stem: int = 16
    width: int = 64
    depth: int = 2
    finer: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, {name: _RANGES[name] for name in ("stem", "width", "depth", "finer")})

    @property
    def widths(self) -> tuple[int, int, int, int]:
        """Channels at 1/4, 1/8, 1/16 and 1/32 of the window's size."""
        return self.width, self.width * 3 // 2, self.width * 2, self.width * 5 // 2


@dataclass(frozen=True)
class DetectorConfig:
    """Settings of a detector's training.

    With the defaults the network has 5.3 MB in half precision.

    stem, width, depth, finer: see DetectorSize. size: of the windows that it is trained on, pixels; a multiple of 32.
    epochs; steps: in an epoch; rounds: how often its windows are learnt from, for machines that learn faster than they
    draw: from the second time on picked, mirrored and lit by chance. batch: windows a step, of which ``crops`` hold one
    face as it is cut out for its landmarks, the others any part of a picture at any scale. learning_rate: of AdamW,
    with a cosine schedule. kernel_rate: of Muon, by which the kernels of convolutions learn, likewise. weight_decay: of
    both. decay: of the weights' moving average, a step. heat_weight, place_weight, doubt_weight, visible_weight,
    parsing_weight, face_weight: of the losses. precision: of the convolutions. validation: faces measured at a
    validation. validate_every: epochs. checkpoint_seconds: between two checkpoints.
    Raises ValueError for impossible sizes.
    """

    stem: int = 16
    width: int = 64
    depth: int = 2
    finer: int = 0
    size: int = 128
    epochs: int = 330
    steps: int = 50
    rounds: int = 1
    batch: int = 32
    crops: float = 0.65
    learning_rate: float = 2e-3
    kernel_rate: float = 1.2e-2
    weight_decay: float = 1e-3
    decay: float = 0.998
    heat_weight: float = 1.0
    place_weight: float = 0.5
    doubt_weight: float = 0.1
    visible_weight: float = 0.3
    parsing_weight: float = 1.0
    face_weight: float = 1.0
    precision: str = "bfloat16"
    validation: int = 200
    validate_every: int = 10
    checkpoint_seconds: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, STEP, self.precision)
        if self.steps % self.rounds:
            raise ValueError(f"steps must be a multiple of rounds, {self.rounds}, found {self.steps}")
        if not 0 < self.faces < self.batch:
            raise ValueError(f"crops must leave windows of both kinds in a batch of {self.batch}, found {self.crops}")

    @property
    def faces(self) -> int:
        """Windows of a step that hold one face as it is cut out."""
        return round(self.crops * self.batch)

    def network(self) -> DetectorSize:
        """The DetectorSize."""
        return DetectorSize(self.stem, self.width, self.depth, self.finer)
