"""Settings of the deformable model and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_DIMENSION, MAX_SEED, check_ranges

_SIZES = {
    "latent": (1, MAX_DIMENSION), "width": (1, 4096), "layers": (1, 32), "hidden": (1, 4096), "frequency": (1e-3, 1e3),
}  # fmt: skip


@dataclass(frozen=True)
class NetworkSize:
    """Size of a SIREN and its hypernetwork; the defaults are the paper's.

    latent: D. width, layers: of the SIREN's sine layers. hidden: width of the hypernetwork. frequency: w0 of the sines.
    Raises ValueError for impossible sizes.
    """

    latent: int = 128
    width: int = 128
    layers: int = 4
    hidden: int = 256
    frequency: float = 30.0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)

    def shapes(self) -> list[tuple[int, ...]]:
        """Shapes of the SIREN's weights and biases in turn."""
        widths = [3, *[self.width] * self.layers, 3]
        shapes: list[tuple[int, ...]] = []
        for inputs, outputs in zip(widths[:-1], widths[1:], strict=True):
            shapes += [(outputs, inputs), (outputs,)]
        return shapes


_CHOICES = {"start": ("random", "principal"), "schedule": ("constant", "cosine"), "precision": ("float32", "bfloat16")}
_RANGES = _SIZES | {
    "latent_std": (1e-6, 1e3), "epochs": (1, 10**6), "patience": (0, 10**6), "batch": (1, 10**5),
    "points": (3, 10**7), "vertex_share": (0, 1), "learning_rate": (1e-9, 1), "latent_rate": (0, 100),
    "data_weight": (0, 1e12), "latent_weight": (0, 1e12), "prior_weight": (0, 1e12), "noise": (0, 10),
    "mixup": (0, 1), "smoothness_weight": (0, 1e12), "validate_every": (1, 10**6), "validation_steps": (1, 10**5),
    "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
}  # fmt: skip


@dataclass(frozen=True)
class DeformableConfig:
    """Settings of an auto-decoder's training.

    With the defaults it takes under an hour on two CPU cores for 3,600 meshes: the hypernetwork is half as wide as the
    paper's, so that the model has 14 MB in half precision, and steps are many and small.

    latent, width, layers, hidden, frequency: see NetworkSize. start: of the training latents, random draws or the
    projections of the shapes on their principal components, both with the standard deviation latent_std. epochs;
    patience: end after so many validations without a better one, 0 for never; batch: meshes a step; points: of a mesh a
    step, of which vertex_share are vertices and the others uniform on the surface. learning_rate of the network,
    latent_rate of the latents in units of latent_std; schedule, precision (of the SIREN's hidden layers).
    data_weight and latent_weight: lambda_mse and lambda_reg of equation 1, for the template in [-1, 1]. prior_weight:
    of the distance of the latents' mean from 0, and of their second moments from latent_std^2. noise: added to latents
    in units of latent_std. mixup: share of the shapes whose place a mixture of two takes. smoothness_weight: of the
    roughness beyond that of the training shapes at latents drawn from the prior. validate_every: epochs.
    validation_steps: of the unseen meshes' codes at a validation. checkpoint_seconds: between two checkpoints.
    Raises ValueError for impossible sizes.
    """

    latent: int = 128
    width: int = 128
    layers: int = 4
    hidden: int = 128
    frequency: float = 30.0
    start: str = "principal"
    latent_std: float = 0.01
    epochs: int = 150
    patience: int = 0
    batch: int = 32
    points: int = 256
    vertex_share: float = 0.5
    learning_rate: float = 5e-4
    latent_rate: float = 0.01
    schedule: str = "cosine"
    precision: str = "bfloat16"
    data_weight: float = 3e3
    latent_weight: float = 0.0
    prior_weight: float = 0.1
    noise: float = 0.05
    mixup: float = 0.5
    smoothness_weight: float = 0.1
    validate_every: int = 10
    validation_steps: int = 20
    checkpoint_seconds: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} must be {' or '.join(choices)}, found {getattr(self, name)!r}")

    def size(self) -> NetworkSize:
        """The NetworkSize."""
        return NetworkSize(self.latent, self.width, self.layers, self.hidden, self.frequency)
