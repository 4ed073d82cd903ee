"""Settings of the detector and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_ranges, check_windows, size_in

FINE = 4
"""Pixels a cell of the heat maps."""

COARSE = 16
"""Pixels a cell of the grid on which faces are found."""

HALF = 2
"""Pixels a cell of the map of regions."""

REACH = 64.0
"""Side of a face, pixels, that the grid gives the size 0."""

_SIZES = {"stem": (4, 512), "width": (8, 512), "depth": (1, 16), "finer": (0, 16)}
_RANGES = TRAINING_RANGES | _SIZES | {
    "rounds": (1, 1000), "crops": (0.1, 0.9), "kernel_rate": (1e-9, 1), "heat_weight": (0, 1e6),
    "place_weight": (0, 1e6), "doubt_weight": (0, 1e6), "visible_weight": (0, 1e6), "parsing_weight": (0, 1e6),
    "face_weight": (0, 1e6),
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
        check_ranges(self, _SIZES)

    @property
    def widths(self) -> tuple[int, int, int, int]:
        """Channels at 1/4, 1/8, 1/16 and 1/32 of the window's size."""
        return self.width, self.width * 3 // 2, self.width * 2, self.width * 5 // 2


@dataclass(frozen=True)
class DetectorConfig(DetectorSize, NetworkTraining):
    """Settings of a detector's training: NetworkTraining's, those of DetectorSize, and its own.

    With the defaults the network has 5.3 MB in half precision.

    rounds: how often the windows of an epoch are learnt from, for machines that learn faster than they draw: from the
    second time on picked, mirrored and lit by chance. crops: share of a batch whose windows hold one face as it is cut
    out for its landmarks; the others are any part of a picture at any scale. kernel_rate: of Muon, by which the kernels
    of convolutions learn, with the same schedule and decay. heat_weight, place_weight, doubt_weight, visible_weight,
    parsing_weight, face_weight: of the losses.
    Raises ValueError for impossible sizes.
    """

    epochs: int = 330
    steps: int = 50
    learning_rate: float = 2e-3
    validate_every: int = 10
    rounds: int = 1
    crops: float = 0.65
    kernel_rate: float = 1.2e-2
    heat_weight: float = 1.0
    place_weight: float = 0.5
    doubt_weight: float = 0.1
    visible_weight: float = 0.3
    parsing_weight: float = 1.0
    face_weight: float = 1.0

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
        return size_in(self, DetectorSize)
