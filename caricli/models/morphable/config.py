"""Settings of the morphable model."""

from dataclasses import dataclass

from caricli.models.config import MAX_DIMENSION, MAX_SEED, check_ranges


@dataclass(frozen=True)
class MorphableConfig:
    """Settings of MorphableModel.

    identity, expression, albedo: dimensions, those of the portrait paper's template models. exaggerated: whether
    exaggerated meshes are trained with, too; the papers' template models are of normal faces. noise: how far a mesh is
    expected from the bases, a share of the head's height; 0.012 are 3 mm: below it errors are smaller, but identity and
    expression make up for each other. seed: of the randomised decompositions and of the albedos.
    Raises ValueError for impossible sizes.
    """

    identity: int = 80
    expression: int = 64
    albedo: int = 80
    exaggerated: bool = False
    noise: float = 0.012
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        sizes = {name: (1, MAX_DIMENSION) for name in ("identity", "expression", "albedo")}
        check_ranges(self, sizes | {"noise": (1e-6, 1), "seed": (0, MAX_SEED)})
