"""How the colours of pixels change with coefficients, and the least squares that come of it."""

from dataclasses import dataclass

import numpy as np
import torch

from caricli.methods.morphable.renderer import Patch, Sight, barycentric
from caricli.render.visibility.corner_mix import corner_mix


@dataclass(frozen=True, eq=False)
class VertexRows:
    """Derivatives of the vertices of a Patch by the coefficients (D,).

    placed: (V, 2) pixels. colours: (V, 3) sRGB. jacobian: (V, 5, D), of colours and pixels.
    """

    placed: np.ndarray
    colours: np.ndarray
    jacobian: np.ndarray


def vertex_rows(patch: Patch, coefficients: np.ndarray) -> VertexRows:
    """Where the vertices of a Patch are and what colours they have, with derivatives."""
    x = torch.as_tensor(coefficients, dtype=patch.mean.dtype)
    shape = patch.layout.shape
    face = patch.layout.face

    def rows(other: torch.Tensor) -> tuple[torch.Tensor, tuple[torch.Tensor, ...]]:
        posed = patch.pose(torch.cat([other[:shape], x[shape:face], other[shape:]])[None])
        values = torch.cat([posed.colours[0], posed.placed[0, :, :2]], 1)
        return values, (values, posed.shade[0])

    # Colours are linear in the albedo, a third of all coefficients.
    jacobian, (values, shade) = torch.func.jacfwd(rows, has_aux=True)(torch.cat([x[:shape], x[face:]]))
    tints = patch.albedo_basis.unflatten(-1, patch.mean.shape).permute(1, 2, 0) * shade[:, None, None]
    tints = torch.nn.functional.pad(tints, (0, 0, 0, 2))
    whole = torch.cat([jacobian[..., :shape], tints, jacobian[..., shape:]], -1)
    return VertexRows(values[:, 3:].numpy(), values[:, :3].numpy(), whole.numpy())


def pixel_rows(patch: Patch, vertices: VertexRows, sight: Sight) -> tuple[np.ndarray, np.ndarray]:
    """Colours (N, 3) of the pixels of a Sight of one picture, and their derivatives (N, 3, D) by the coefficients.

    At a pixel that stays where it is, the surface glides by: the colour gets what its place on the surface gets, less
    what the slope of the colour across the picture takes along.
    """
    corners = patch.faces[sight.face].cpu().numpy()
    pixels = torch.stack([sight.column, sight.row], -1).cpu().numpy()
    places = vertices.placed[corners]
    weights = barycentric(torch.as_tensor(places), torch.as_tensor(pixels)).numpy()
    mean = corner_mix(corners, weights, len(vertices.placed))
    tints = vertices.colours[corners]
    edges = (places[:, 1:] - places[:, :1]).transpose(0, 2, 1)
    slopes = np.matmul((tints[:, 1:] - tints[:, :1]).transpose(0, 2, 1), np.linalg.inv(edges))
    flat = vertices.jacobian.reshape(len(vertices.placed), -1)
    glided = (mean @ flat).reshape(len(corners), 5, -1)
    return (weights[:, :, None] * tints).sum(1), glided[:, :3] - np.matmul(slopes, glided[:, 3:])
