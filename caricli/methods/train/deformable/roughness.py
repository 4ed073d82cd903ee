"""How rough a network's displacements are, compared with those of the shapes that it learns from."""

import igl
import numpy as np
import torch

from caricli.methods.train.deformable.surface import Surface

DRAWN_VERTICES = 64
"""Vertices a step at which roughness is measured: enough for its mean to be steady over a few steps."""

_LEAST = 1e-6  # of the network's coordinates: what is smooth everywhere must not divide by nothing


class Roughness:
    """How much farther displacements are from the mean of their neighbours' than in the training shapes."""

    def __init__(self, surface: Surface, shapes: torch.Tensor) -> None:
        """shapes: (N, V, 3) displacements of the training shapes."""
        neighbours = igl.adjacency_list(surface.faces.cpu().numpy())
        width = max(len(ring) for ring in neighbours)
        # Short rings are filled up with the vertex itself, at no weight.
        rings = [[*ring, *[k] * (width - len(ring))] for k, ring in enumerate(neighbours)]
        weights = [[*[1 / len(ring)] * len(ring), *[0.0] * (width - len(ring))] for ring in neighbours]
        device = surface.vertices.device
        self.surface = surface
        self.rings = torch.tensor(rings, device=device)
        self.weights = torch.tensor(weights, device=device)
        squares = torch.zeros(len(rings), device=device)
        for shape in shapes:
            squares += _laplacians(shape, shape[self.rings], self.weights).square().sum(-1)
        self.usual = (squares / len(shapes)).sqrt() + _LEAST

    def __call__(self, network: torch.nn.Module, latents: torch.Tensor, generator: np.random.Generator) -> torch.Tensor:
        """The mean square over latents (B, D) and drawn vertices, 1 where they are as rough as the shapes."""
        drawn = generator.choice(len(self.rings), min(DRAWN_VERTICES, len(self.rings)), replace=False)
        chosen = torch.from_numpy(drawn).to(latents.device)
        ids = torch.cat([chosen[:, None], self.rings[chosen]], dim=1)
        fields = network(latents, self.surface.at_vertices(ids.flatten())).unflatten(1, ids.shape)
        rough = _laplacians(fields[:, :, 0], fields[:, :, 1:], self.weights[chosen]).norm(dim=-1)
        return (rough / self.usual[chosen]).square().mean()


def _laplacians(centres: torch.Tensor, rings: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
    return centres - (rings * weights[..., None]).sum(-2)
