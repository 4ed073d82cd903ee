"""What the training of a coarse network minimises: equations 3 to 6 on pictures, and distances to what is true."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from caricli.methods.morphable.energy import (
    SIDE,
    EnergyWeights,
    Observed,
    landmark_loss,
    photometric_loss,
    regularisation,
)
from caricli.methods.morphable.renderer import MorphableRenderer, head_rotations
from caricli.methods.train.coarse.coarse_faces import TrueFace
from caricli.models.coarse.config import CoarseConfig

ELSEWHERE = 0.1
"""Weight of a vertex that is not on the face, of one that is."""

THINNED = 4
"""Of so many vertices one is compared with the true one, and all on which landmarks can stand."""

_SMALLEST = 1e-5
"""Metres, of distances whose square roots have derivatives."""


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true of B faces, of the K vertices of a ThinFace.

    vertices: (B, K, 3) metres. colours: (B, K, 3) sRGB, unlit. rotation: (B, 3, 3). latent: (B, I + E) the likeliest
    for all vertices.
    """

    vertices: torch.Tensor
    colours: torch.Tensor
    rotation: torch.Tensor
    latent: torch.Tensor


class ThinFace:
    """Some of a morphable model's vertices, which say nearly as much as all."""

    def __init__(self, renderer: MorphableRenderer) -> None:
        """renderer: of the model."""
        model = renderer.model
        template = model.template
        self.model = model
        self.renderer = renderer
        self.ids = np.union1d(template.annotation.anchor_ids(), np.arange(0, len(template.vertices), THINNED))
        self.places = torch.zeros(len(template.vertices), dtype=torch.long)
        self.places[self.ids] = torch.arange(len(self.ids))
        weights = np.where(template.mask("face")[self.ids], 1.0, ELSEWHERE)
        self.weights = torch.from_numpy(weights / weights.sum()).float()
        self.mean = torch.from_numpy(model.mean[self.ids]).float()
        self.basis = _flat(model.basis[:, self.ids])
        self.colour_mean = torch.from_numpy(model.albedo.mean[self.ids]).float()
        self.colour_basis = _flat(model.albedo.basis[:, self.ids])

    def vertices(self, coefficients: torch.Tensor) -> torch.Tensor:
        """(B, K, 3) metres, of coefficients (B, D)."""
        latent = coefficients[:, : self.renderer.layout.shape]
        return self.mean + (latent @ self.basis).unflatten(-1, self.mean.shape)

    def colours(self, coefficients: torch.Tensor) -> torch.Tensor:
        """(B, K, 3) sRGB, unlit."""
        albedo = self.renderer.layout.parts(coefficients)["albedo"]
        return self.colour_mean + (albedo @ self.colour_basis).unflatten(-1, self.mean.shape)

    def project(self, coefficients: torch.Tensor, anchors: torch.Tensor) -> torch.Tensor:
        """(B, L, 2) pixels of vertices (B, L) on which landmarks can stand, as MorphableRenderer places them."""
        renderer = self.renderer
        pose = renderer.layout.parts(coefficients)["pose"]
        latent = coefficients[:, : renderer.layout.shape]
        own = self.vertices(coefficients).gather(1, self.places[anchors][..., None].expand(-1, -1, 3))
        middle = renderer.middle + latent @ renderer.middle_basis
        turned = (own - middle[:, None]) @ head_rotations(pose[:, :3]).mT
        return pose[:, 5, None, None] * turned[..., :2] + pose[:, None, 3:5]

    def truth(self, faces: Sequence[TrueFace]) -> Truth:
        """What is true of faces."""
        latents = self.model.encode(np.stack([face.vertices for face in faces]).astype(float))
        vertices = np.stack([face.vertices[self.ids] for face in faces])
        colours = np.stack([face.albedo[self.ids] for face in faces])
        rotation = np.stack([face.rotation for face in faces])
        return Truth(*(torch.from_numpy(value).float() for value in (vertices, colours, rotation, latents)))


def window_energy(
    thin: ThinFace, coefficients: torch.Tensor, observed: Observed, anchors: torch.Tensor
) -> torch.Tensor:
    """Equation 3, (B,) of faces in windows, the photometric term of the first of them alone.

    observed: its images and confidence are of the first N <= B windows, its points of all. anchors: (B, L) vertices
    that the landmarks stand on.
    """
    weights = EnergyWeights()
    renderer = thin.renderer
    count, height, width = observed.images.shape[:3]
    projected = thin.project(coefficients, anchors)
    marks = landmark_loss(projected, observed.points, observed.weights) * (SIDE / max(height, width)) ** 2
    size = regularisation(coefficients, renderer.layout, weights)
    total = weights.landmarks * marks + weights.regularisation * size
    if not count:
        return total
    painted = renderer.pose(coefficients[:count])
    sight = renderer.look(painted, height, width)
    photometric = photometric_loss(renderer.paint(painted, sight), sight, observed)
    return torch.cat([total[:count] + weights.photometric * photometric, total[count:]])


def truth_loss(
    thin: ThinFace, coefficients: torch.Tensor, truth: Truth, config: CoarseConfig
) -> tuple[torch.Tensor, torch.Tensor]:
    """Distance of faces (B, D) to the true ones, by the weights of a CoarseConfig, means over the faces.

    Returns the loss, and the mean distance of the vertices as a share of the head's height.
    """
    layout = thin.renderer.layout
    gaps = ((thin.vertices(coefficients) - truth.vertices) ** 2).sum(-1)
    distance = (torch.sqrt(gaps + _SMALLEST**2) @ thin.weights).mean() / thin.model.template.height
    turns = head_rotations(layout.parts(coefficients)["pose"][:, :3]) - truth.rotation
    albedo = ((thin.colours(coefficients) - truth.colours).abs().mean(-1) @ thin.weights).mean()
    apart = ((coefficients[:, : layout.shape] - truth.latent) ** 2).mean()
    loss = 100 * config.shape_weight * distance + config.turn_weight * (turns**2).sum((1, 2)).mean()
    loss = loss + config.albedo_weight * albedo + config.coefficient_weight * apart
    return loss, distance.detach()


def _flat(basis: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(basis.reshape(len(basis), -1)).float()
