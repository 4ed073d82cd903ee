"""Latents of shapes that a network does not learn from."""

import torch

from caricli.methods.train.deformable.surface import Points
from caricli.models.deformable.config import DeformableConfig


class CodeFit:
    """Codes of shapes and Adam over them; the network stays as it is.

    Minimises ``data_weight mean |d_i - S(p_i; z_k)|^2 + latent_weight mean z_k^2`` (deformable paper, equation 1).
    """

    def __init__(self, codes: torch.Tensor, rate: float, config: DeformableConfig) -> None:
        """codes: (U, D) to begin with. rate: of learning, in units of the config's latent_std."""
        self.config = config
        self.codes = torch.nn.Parameter(codes.detach().clone())
        self.optimiser = torch.optim.Adam([self.codes], lr=rate * config.latent_std)

    def step(self, network: torch.nn.Module, points: Points, displacements: torch.Tensor) -> None:
        """Go one step down. points: where. displacements: (U, V, 3) of the shapes, in the network's coordinates."""
        squares = square_distances(network, self.codes, points, displacements)
        loss = self.config.data_weight * squares.mean() + self.config.latent_weight * self.codes.square().mean()
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()


def square_distances(
    network: torch.nn.Module, latents: torch.Tensor, points: Points, displacements: torch.Tensor
) -> torch.Tensor:
    """(B, n) squared distances of a network's points from those of shapes, in its coordinates.

    latents: (B, D). displacements: (B, V, 3) of the shapes.
    """
    return (network(latents, points) - points.values(displacements)).square().sum(-1)
