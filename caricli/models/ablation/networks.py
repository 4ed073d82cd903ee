"""The networks that the SIREN hypernetwork is compared with (deformable paper, section 4.2).

As the hypernetwork they begin with small outputs that hardly depend on the latent, and their latents are scaled so that
they can learn from them as fast; without that they are far behind for no reason of their own.
"""

from dataclasses import dataclass
from math import sqrt

import torch
from torch import nn

from caricli.models.config import DeformableConfig, check_ranges
from caricli.models.deformable.model import Affine, siren, siren_start

_SLOPE = 0.1


@dataclass(frozen=True)
class AblationConfig(DeformableConfig):
    """Settings of the ablation: those of a DeformableConfig, which all networks share, and these.

    meshes, unseen: how many of the training and of the test meshes are used, 0 for all. array_hidden: width of the
    vertex arrays' hidden layer. code_steps: of the unseen meshes' codes after the training.
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

    def __post_init__(self):
        """Refuse impossible sizes."""
        super().__post_init__()
        ranges = {"meshes": (0, 10**6), "unseen": (0, 10**6), "array_hidden": (1, 10**5), "code_steps": (1, 10**6)}
        check_ranges(self, ranges)


class VertexArray(nn.Module):
    """All vertices at once: latent -> hidden -> 3 V with a leaky ReLU (supplement 3).

    Positions and displacements differ by a constant, so only in where training starts: the origin or the template.
    """

    def __init__(self, size, hidden, count, latent_std, generator, positions=False):
        """size: NetworkSize. hidden: width. count: V. latent_std, generator: see ConditionedSiren.

        positions: put out positions instead of displacements.
        """
        super().__init__()
        self.first = Affine(size.latent, hidden, generator)
        self.last = Affine(hidden, 3 * count, generator, scale=0.01)
        self.latent_std, self.positions = latent_std, positions

    def forward(self, latents, points):
        """Latents (B, D) and Points to displacements (B, n, 3)."""
        hidden = nn.functional.leaky_relu(self.first(latents / self.latent_std), _SLOPE)
        fields = points.values(self.last(hidden).unflatten(-1, (-1, 3)))
        return fields - points.positions if self.positions else fields


class ConditionedSiren(nn.Module):
    """One SIREN for all shapes; the latent is concatenated to the inputs of its first and its middle layer.

    That is the same as a linear function of the latent added to those layers' biases, and so it is computed.
    """

    def __init__(self, size, latent_std, generator, precision=torch.float32):
        """size: NetworkSize. latent_std: latents are divided by it, so that they weigh as much as features do.

        generator: torch.Generator of the initial weights. precision: see ``siren``.
        """
        super().__init__()
        self.size, self.latent_std, self.precision = size, latent_std, precision
        self.middle = max(1, size.layers // 2)
        self.tensors = nn.ParameterList(siren_start(size, generator))
        # The features of the middle layer share its input with the latent: weights for the sum of both.
        self.tensors[2 * self.middle].data *= sqrt(size.width / (size.width + size.latent))
        self.latent_weights = nn.ParameterList()
        for inputs, outputs in zip((3, size.width), (self.tensors[1], self.tensors[2 * self.middle + 1]), strict=True):
            bound = sqrt(6 / (inputs + size.latent)) / size.frequency
            weight = torch.empty(len(outputs), size.latent).uniform_(-bound, bound, generator=generator)
            self.latent_weights.append(weight)

    def forward(self, latents, points):
        """Latents (B, D) and Points to displacements (B, n, 3)."""
        tensors = list(self.tensors)
        for layer, weight in zip((0, self.middle), self.latent_weights, strict=True):
            tensors[2 * layer + 1] = tensors[2 * layer + 1] + latents / self.latent_std @ weight.mT
        return siren(points.positions, tensors, self.size.frequency, self.precision)
