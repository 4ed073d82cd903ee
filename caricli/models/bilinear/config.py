"""Settings of the bilinear model."""

from dataclasses import dataclass

from caricli.models.config import MAX_DIMENSION, MAX_SEED, check_ranges


@dataclass(frozen=True)
class BilinearConfig:
    """Settings of BilinearModel.

    identity, expression: dimensions of the two modes, the sketch paper's; fewer where the data have fewer. seed: goes
    into the recipe alone, as nothing is random.
    Raises ValueError for impossible sizes.
    """

    identity: int = 50
    expression: int = 16
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        sizes = {name: (1, MAX_DIMENSION) for name in ("identity", "expression")}
        check_ranges(self, sizes | {"seed": (0, MAX_SEED)})
