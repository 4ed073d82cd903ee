"""The energy of a morphable model against a picture (portrait paper, equations 3 to 6)."""

from dataclasses import dataclass

import torch

from caricli.methods.morphable.coefficients import CoefficientLayout
from caricli.methods.morphable.renderer import MorphableRenderer, Sight

SIDE = 224
"""Pixels of the pictures that the weights are for; landmarks of others are scaled to it."""


@dataclass(frozen=True)
class EnergyWeights:
    """Weights of equations 3 and 6, as published.

    landmarks: of squared pixels of a picture of SIDE pixels. photometric: of squared differences of sRGB, 1 is white.
    regularisation: of the coefficients, in squares of which identity, expression and albedo count.
    """

    landmarks: float = 2e-3
    photometric: float = 2.0
    regularisation: float = 3e-4
    identity: float = 1.2
    expression: float = 1.0
    albedo: float = 1.2e-3


@dataclass(frozen=True, eq=False)
class Observed:
    """Pictures, and what is known of the faces in them.

    images: (B, H, W, 3) sRGB from 0 to 1. confidence: (B, H, W) from 0 to 1, how surely a pixel is of the face.
    points: (B, L, 2) pixels, (0, 0) the centre of the top left one, NaN where unknown. weights: (B, L) of them, or None
    for one each.
    """

    images: torch.Tensor
    confidence: torch.Tensor
    points: torch.Tensor
    weights: torch.Tensor | None = None


@dataclass(frozen=True, eq=False)
class Energy:
    """Terms of equation 3 for each of B pictures, (B,) without their weights, and what they come to."""

    landmarks: torch.Tensor
    photometric: torch.Tensor
    regularisation: torch.Tensor
    total: torch.Tensor


def energy(
    renderer: MorphableRenderer,
    coefficients: torch.Tensor,
    observed: Observed,
    weights: EnergyWeights = EnergyWeights(),  # noqa: B008 (frozen)
) -> Energy:
    """Equation 3 with derivatives by the coefficients (B, D): L_lan, L_photo and L_reg.

    Where the jaw's landmarks stand and which triangle a pixel sees is looked up anew and counts as fixed.
    """
    posed = renderer.pose(coefficients)
    height, width = observed.images.shape[1:3]
    projected = renderer.landmarks(posed, renderer.anchors(posed, observed.points.shape[1]))
    sight = renderer.look(posed, height, width)
    marks = landmark_loss(projected, observed.points, observed.weights) * (SIDE / max(height, width)) ** 2
    photometric = photometric_loss(renderer.paint(posed, sight), sight, observed)
    size = regularisation(coefficients, renderer.layout, weights)
    total = weights.landmarks * marks + weights.photometric * photometric + weights.regularisation * size
    return Energy(marks, photometric, size, total)


def landmark_loss(projected: torch.Tensor, points: torch.Tensor, weights: torch.Tensor | None = None) -> torch.Tensor:
    """Equation 4, (B,) squared pixels: weighted mean of squared distances to the points (B, L, 2) there are."""
    given = points.isfinite().all(-1)
    gaps = torch.where(given[..., None], projected - points, torch.zeros_like(projected))
    squares = (gaps**2).sum(-1)
    squares = squares if weights is None else weights * squares
    return squares.sum(-1) / given.sum(-1).clamp(min=1)


def photometric_loss(colours: torch.Tensor, sight: Sight, observed: Observed) -> torch.Tensor:
    """Equation 5, (B,): squared differences of colours (N, 3) to the pictures under their confidence, by its sum."""
    confidence = sight.of(observed.confidence)
    squares = ((confidence[:, None] * (colours - sight.of(observed.images))) ** 2).sum(-1)
    nothing = torch.zeros(len(observed.images), dtype=colours.dtype, device=colours.device)
    total = nothing.index_add(0, sight.picture, squares)
    return total / nothing.index_add(0, sight.picture, confidence.to(colours.dtype)).clamp(min=1)


def regularisation(coefficients: torch.Tensor, layout: CoefficientLayout, weights: EnergyWeights) -> torch.Tensor:
    """Equation 6, (B,) of coefficients (B, D)."""
    parts = layout.parts(coefficients)
    prices = {"identity": weights.identity, "expression": weights.expression, "albedo": weights.albedo}
    return torch.stack([price * (parts[name] ** 2).sum(-1) for name, price in prices.items()]).sum(0)
