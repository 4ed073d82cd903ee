"""Settings of the linear models."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LinearConfig:
    """dimension: of the latent. seed: of the randomised decomposition."""

    dimension: int = 128
    seed: int = 0

    def __post_init__(self):
        """Refuse impossible sizes."""
        if not 1 <= self.dimension <= 4096:
            raise ValueError(f"dimension must be from 1 to 4096, found {self.dimension}")
        if self.seed < 0:
            raise ValueError(f"seed must not be negative, found {self.seed}")
