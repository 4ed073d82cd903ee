"""Settings of the landmark map."""

from dataclasses import dataclass

from caricli.models.config import check_ranges


@dataclass(frozen=True)
class LandmarkMapConfig:
    """Settings of a LandmarkMap's training.

    dimension: principal components of a domain. width: of the generators' hidden layers, judge_width: of the
    discriminators'. least: smallest singular value of the linear map that training starts from; the inverse may
    exaggerate 1 / 0.7 times as much, and lower is nearer to the true faces, and wilder back. adversarial, cycle,
    characteristic: weights of the losses, the latter two as in CariGANs; with an adversarial weight of 1 mapped faces
    vary more like real ones and lie farther from the true ones. views: random poses of every mesh. epochs, batch,
    learning_rate.
    Raises ValueError for impossible sizes.
    """

    dimension: int = 32
    width: int = 64
    judge_width: int = 128
    least: float = 0.7
    adversarial: float = 0.3
    cycle: float = 10.0
    characteristic: float = 1.0
    views: int = 8
    epochs: int = 10
    batch: int = 256
    learning_rate: float = 2e-4

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        ranges = {
            "dimension": (1, 136),
            "width": (1, 4096),
            "judge_width": (1, 4096),
            "least": (0.1, 1),
            "adversarial": (0, 1e6),
            "cycle": (0, 1e6),
            "characteristic": (0, 1e6),
            "views": (1, 1000),
            "epochs": (0, 10**6),
            "batch": (1, 10**5),
            "learning_rate": (1e-9, 1),
        }
        check_ranges(self, ranges)
