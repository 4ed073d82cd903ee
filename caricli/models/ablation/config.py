"""Settings of the ablation."""

from dataclasses import dataclass

from caricli.models.config import check_ranges
from caricli.models.deformable.config import DeformableConfig


@dataclass(frozen=True)
class AblationConfig(DeformableConfig):
    """Settings of the ablation: those of a DeformableConfig, which all networks share, and these.

    Equation 1 alone, without the further terms of DeformableConfig.

    meshes, unseen: how many of the training and of the test meshes are used, 0 for all. array_hidden: width of the
    vertex arrays' hidden layer. code_steps: of the unseen meshes' codes after the training.
    Raises ValueError for impossible sizes.
    """

    start: str = "random"
    prior_weight: float = 0.0
    noise: float = 0.0
    mixup: float = 0.0
    smoothness_weight: float = 0.0
    meshes: int = 600
    unseen: int = 90
    array_hidden: int = 400
    code_steps: int = 800

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        super().__post_init__()
        ranges = {"meshes": (0, 10**6), "unseen": (0, 10**6), "array_hidden": (1, 10**5), "code_steps": (1, 10**6)}
        check_ranges(self, ranges)
