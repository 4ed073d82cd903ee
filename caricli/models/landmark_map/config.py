"""Settings of the landmark map."""

from dataclasses import dataclass

from caricli.models.config import check_ranges


@dataclass(frozen=True)
class LandmarkMapConfig:
    """Settings of a LandmarkMap's training.

    styles: length of the code of a caricature's style. noise: standard deviation of a landmark that both domains share,
    of the distance between the eyes. views: random poses of every mesh. The first two were chosen on people held out of
    the training (``evaluate_landmark_map``, "held out").
    Raises ValueError for impossible sizes.
    """

    styles: int = 2
    noise: float = 0.03
    views: int = 8

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, {"styles": (1, 136), "noise": (1e-4, 1), "views": (1, 1000)})
