"""Settings of the coarse network and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_levels, check_ranges, check_windows, size_in

_SIZES = {"stem": (4, 512), "kept": (1, 4096), "hidden": (1, 8192), "glance": (0, 256)}
_RANGES = TRAINING_RANGES | _SIZES | {
    "rounds": (1, 1000), "painted": (0, 4096), "unmarked": (0, 4096), "imagined": (0, 4096), "unseen": (0, 0.9),
    "shape_weight": (0, 1e6), "turn_weight": (0, 1e6), "albedo_weight": (0, 1e6), "coefficient_weight": (0, 1e6),
    "energy_weight": (0, 1e6),
}  # fmt: skip
STEP = 32
"""Pixels that the network reduces to one: a window has a multiple of them."""

_LEVELS = 4


@dataclass(frozen=True)
class CoarseSize:
    """Size of the network.

    stem: channels at half of the window's size. widths, blocks: channels and residual blocks at 1/4, 1/8, 1/16 and
    1/32 of it. bottleneck: whether a block is one of three convolutions with a narrow middle instead of two. kept:
    channels of the last level that go on, for each of 4 x 4 places. hidden: numbers between them and the coefficients.
    landmarks: whether it is told the landmarks beside the picture. glance: numbers of what it sees at each of them, at
    1/8 of the window's size.
    Raises ValueError for impossible sizes.
    """

    stem: int = 16
    widths: tuple[int, ...] = (64, 96, 128, 160)
    blocks: tuple[int, ...] = (1, 1, 2, 2)
    bottleneck: bool = False
    kept: int = 48
    hidden: int = 384
    landmarks: bool = True
    glance: int = 8

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)
        if self.glance and not self.landmarks:
            raise ValueError("glance must be 0 where the network is not told the landmarks")
        check_levels(self, _LEVELS)


@dataclass(frozen=True)
class CoarseConfig(CoarseSize, NetworkTraining):
    """Settings of a coarse network's training: NetworkTraining's, those of CoarseSize, and its own.

    With the defaults the network has 7.0 MB in half precision, and its encoder is that of the bundled detector, with
    whose weights it begins.

    rounds: how often the windows of an epoch are gone through: with more than one the encoder stays as it is, and the
    rest costs little. unmarked: windows of a batch that are of pictures without truth, where there are any. painted:
    those that are drawn for the photometric loss. imagined: faces a step that are in no picture, mixed of those that
    are, whose landmarks alone are told. unseen: share of what is seen, at landmarks and of the whole, that is left out
    at a step. shape_weight: of the mean distance of the vertices to the true ones, percent of the head's height.
    turn_weight: of the rotations' squared difference. albedo_weight: of the mean difference of the colours, 1 is white.
    coefficient_weight: of the mean squared difference of the face's coefficients. energy_weight: of equation 3, whose
    own weights are as published.
    Raises ValueError for impossible sizes.
    """

    epochs: int = 200
    steps: int = 50
    weight_decay: float = 1e-2
    rounds: int = 1
    painted: int = 6
    unmarked: int = 8
    imagined: int = 32
    unseen: float = 0.3
    shape_weight: float = 1.0
    turn_weight: float = 5.0
    albedo_weight: float = 2.0
    coefficient_weight: float = 0.02
    energy_weight: float = 1.0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        self.network()
        if self.imagined and not self.landmarks:
            raise ValueError("imagined must be 0 where the network is not told the landmarks")
        check_windows(self.size, STEP, self.precision)
        if self.steps % self.rounds:
            raise ValueError(f"steps must be a multiple of rounds, {self.rounds}, found {self.steps}")
        if self.painted + self.unmarked >= self.batch:
            raise ValueError(f"painted and unmarked together must be less than batch, {self.batch}, found more")

    def network(self) -> CoarseSize:
        """The CoarseSize."""
        return size_in(self, CoarseSize)
