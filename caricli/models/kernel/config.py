"""Settings of the kernel model."""

from dataclasses import dataclass

from caricli.models.config import MAX_DIMENSION, MAX_SEED, check_ranges


@dataclass(frozen=True)
class KernelConfig:
    """Settings of KernelModel.

    dimension: of the latent; 128 is the size of the deformable paper's. components: of the shapes, those of the latent
    included; more cost space, 25 kB each. centres: of the kernel; twice as many bring another 0.2 % of the error.
    width: of the kernel, for latents of length 1. ridge: variance of the noise of the coefficients. near: how much more
    a vertex weighs at a landmark; without it test errors are lower, and errors of fitted landmarks higher. radius:
    about how far that reaches, a share of the head's height; 0.015 are 4 mm. seed: of the randomised decomposition and
    of the choice of centres.
    Raises ValueError for impossible sizes.
    """

    dimension: int = 128
    components: int = 320
    centres: int = 2048
    width: float = 0.5
    ridge: float = 0.1
    near: float = 7.0
    radius: float = 0.015
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        ranges = {
            "dimension": (1, MAX_DIMENSION),
            "components": (self.dimension, 8192),
            "centres": (1, 10**5),
            "width": (1e-3, 1e3),
            "ridge": (1e-9, 1e9),
            "near": (0, 1e6),
            "radius": (1e-6, 1e3),
            "seed": (0, MAX_SEED),
        }
        check_ranges(self, ranges)
