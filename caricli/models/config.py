"""Settings of the shape models."""

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


@dataclass(frozen=True)
class KernelConfig:
    """Settings of KernelModel; the defaults are those of configs/kernel/default.yaml.

    dimension: of the latent. components: of the shapes, those of the latent included. centres: of the kernel. width: of
    the kernel, for latents of length 1. ridge: variance of the noise of the coefficients. near, radius: a vertex weighs
    up to near more within about that distance of a landmark, a share of the head's height. seed: of the randomised
    decomposition and of the choice of centres.
    """

    dimension: int = 128
    components: int = 320
    centres: int = 2048
    width: float = 0.5
    ridge: float = 0.1
    near: float = 7.0
    radius: float = 0.015
    seed: int = 0

    def __post_init__(self):
        """Refuse impossible sizes."""
        ranges = {
            "dimension": (1, 4096), "components": (self.dimension, 8192), "centres": (1, 10**5), "width": (1e-3, 1e3),
            "ridge": (1e-9, 1e9), "near": (0, 1e6), "radius": (1e-6, 1e3), "seed": (0, 2**32 - 1),
        }  # fmt: skip
        check_ranges(self, ranges)


@dataclass(frozen=True)
class MorphableConfig:
    """Settings of MorphableModel; the defaults are those of configs/morphable/default.yaml.

    identity, expression, albedo: dimensions. noise: how far a mesh is expected from the bases, a share of the head's
    height. seed: of the randomised decompositions and of the albedos.
    """

    identity: int = 80
    expression: int = 64
    albedo: int = 80
    noise: float = 0.012
    seed: int = 0

    def __post_init__(self):
        """Refuse impossible sizes."""
        sizes = {name: (1, 4096) for name in ("identity", "expression", "albedo")}
        check_ranges(self, sizes | {"noise": (1e-6, 1), "seed": (0, 2**32 - 1)})


@dataclass(frozen=True)
class NetworkSize:
    """latent: D. width, layers: of the SIREN's sine layers. hidden: of the hypernetwork. frequency: w0 of the sines."""

    latent: int = 128
    width: int = 128
    layers: int = 4
    hidden: int = 256
    frequency: float = 30.0

    def shapes(self):
        """Shapes of the SIREN's weights and biases in turn."""
        widths = [3, *[self.width] * self.layers, 3]
        return [shape for a, b in zip(widths[:-1], widths[1:], strict=True) for shape in ((b, a), (b,))]


_CHOICES = {"start": ("random", "principal"), "schedule": ("constant", "cosine"), "precision": ("float32", "bfloat16")}


@dataclass(frozen=True)
class DeformableConfig:
    """Settings of an auto-decoder's training; the defaults are those of configs/deformable/default.yaml.

    latent, width, layers, hidden, frequency: see NetworkSize. start: of the training latents, random draws or the
    projections of the shapes on their principal components, both with the standard deviation latent_std. epochs;
    patience: end after so many validations without a better one, 0 for never; batch: meshes a step; points: of a mesh a
    step, of which vertex_share are vertices and the others uniform on the surface. learning_rate of the network,
    latent_rate of the latents in units of latent_std; schedule, precision (of the SIREN's hidden layers).
    data_weight and latent_weight: lambda_mse and lambda_reg of equation 1, for the template in [-1, 1]. prior_weight:
    of the distance of the latents' covariance from latent_std^2. noise: added to latents in units of latent_std.
    mixup: share of the shapes whose place a mixture of two takes. smoothness_weight: of the roughness beyond that of
    the training shapes at latents drawn from the prior. validate_every: epochs. validation_steps: of the unseen meshes'
    codes at a validation. checkpoint_seconds: between two checkpoints.
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

    def __post_init__(self):
        """Refuse impossible sizes."""
        ranges = {
            "latent": (1, 4096), "width": (1, 4096), "layers": (1, 32), "hidden": (1, 4096), "frequency": (1e-3, 1e3),
            "latent_std": (1e-6, 1e3), "epochs": (1, 10**6), "patience": (0, 10**6), "batch": (1, 10**5),
            "points": (3, 10**7), "vertex_share": (0, 1), "learning_rate": (1e-9, 1), "latent_rate": (0, 100),
            "data_weight": (0, 1e12), "latent_weight": (0, 1e12), "prior_weight": (0, 1e12), "noise": (0, 10),
            "mixup": (0, 1), "smoothness_weight": (0, 1e12), "validate_every": (1, 10**6),
            "validation_steps": (1, 10**5), "checkpoint_seconds": (0, 10**5), "seed": (0, 2**32 - 1),
        }  # fmt: skip
        check_ranges(self, ranges)
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} must be {' or '.join(choices)}, found {getattr(self, name)!r}")

    def size(self):
        """The NetworkSize."""
        return NetworkSize(self.latent, self.width, self.layers, self.hidden, self.frequency)


@dataclass(frozen=True)
class LandmarkMapConfig:
    """Settings of a landmark map; the defaults are those of configs/landmark_map/default.yaml.

    dimension: principal components of a domain. width: of the generators' hidden layers, judge_width: of the
    discriminators'. least: smallest singular value of the linear map that training starts from. adversarial, cycle,
    characteristic: weights of the losses. views: random poses of every mesh. epochs, batch, learning_rate.
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

    def __post_init__(self):
        """Refuse impossible sizes."""
        ranges = {
            "dimension": (1, 136), "width": (1, 4096), "judge_width": (1, 4096), "least": (0.1, 1),
            "adversarial": (0, 1e6), "cycle": (0, 1e6), "characteristic": (0, 1e6), "views": (1, 1000),
            "epochs": (0, 10**6), "batch": (1, 10**5), "learning_rate": (1e-9, 1),
        }  # fmt: skip
        check_ranges(self, ranges)


def check_ranges(config, ranges):
    """Raise ValueError where a setting is out of its range. ranges: names to (low, high)."""
    for name, (low, high) in ranges.items():
        if not low <= getattr(config, name) <= high:
            raise ValueError(f"{name} must be from {low:g} to {high:g}, found {getattr(config, name)}")
