"""Places on the template's surface, where networks are trained and measured (deformable paper, supplement 2)."""

from dataclasses import dataclass

import igl
import numpy as np
import torch

from caricli.models.deformable.model import UnitBox


@dataclass(frozen=True)
class Points:
    """Places on the template's surface.

    corners: (n, 3) vertex ids.
    weights: (n, 3) of the corners, sum 1.
    positions: (n, 3) in the network's coordinates, from -1 to 1.
    """

    corners: torch.Tensor
    weights: torch.Tensor
    positions: torch.Tensor

    def values(self, fields: torch.Tensor) -> torch.Tensor:
        """Interpolate what is known at the vertices. fields: (..., V, 3). Returns (..., n, 3)."""
        return (fields[..., self.corners, :] * self.weights[:, :, None]).sum(-2)


class Surface:
    """The network's template, in its own coordinates, and places drawn on it."""

    def __init__(self, box: UnitBox, faces: np.ndarray, device: str = "cpu") -> None:
        """box: the network's coordinates. faces: (F, 3). device: where the tensors go."""
        self.box = box
        self.vertices = torch.from_numpy(box.normalise(box.points).astype(np.float32)).to(device)
        self.faces = torch.from_numpy(np.asarray(faces, dtype=np.int64)).to(device)
        areas = igl.doublearea(np.asarray(box.points, dtype=np.float64), np.asarray(faces))
        self.areas = areas / areas.sum()

    def at_vertices(self, ids: np.ndarray | torch.Tensor | None = None) -> Points:
        """Points at vertices. ids: (n,), or None for all of them."""
        numbers = np.arange(len(self.vertices)) if ids is None else ids
        chosen = torch.as_tensor(numbers, device=self.vertices.device)
        weights = torch.zeros(len(chosen), 3, device=chosen.device)
        weights[:, 0] = 1
        return Points(chosen[:, None].expand(-1, 3), weights, self.vertices[chosen])

    def draw(self, count: int, vertex_share: float, generator: np.random.Generator) -> Points:
        """Draw vertices without repetition and uniform points of the surface.

        count: of points in all. vertex_share: of them at vertices, from 0 to 1; with 1 there are no others, even where
        there are fewer vertices.
        """
        at_vertices = min(round(count * vertex_share), len(self.vertices))
        count = at_vertices if vertex_share == 1 else count
        ids = generator.permutation(len(self.vertices))[:at_vertices]
        triangles = generator.choice(len(self.faces), count - at_vertices, p=self.areas)
        drawn = generator.dirichlet(np.ones(3), count - at_vertices).astype(np.float32)
        first = self.at_vertices(ids)
        corners = torch.cat([first.corners, self.faces[torch.from_numpy(triangles).to(self.faces.device)]])
        weights = torch.cat([first.weights, torch.from_numpy(drawn).to(self.faces.device)])
        return Points(corners, weights, (self.vertices[corners] * weights[:, :, None]).sum(-2))

    def displacements(self, shapes: np.ndarray) -> torch.Tensor:
        """Shapes (N, V, 3), metres, as displacements in the network's coordinates."""
        moved = (np.asarray(shapes) - self.box.points) * self.box.scale
        return torch.from_numpy(moved.astype(np.float32)).to(self.vertices.device)


@dataclass(frozen=True, eq=False)
class TrainingMeshes:
    """What an auto-decoder is trained and judged on.

    surface: Surface of the template.
    shapes: (N, V, 3) metres, to learn from.
    unseen: (U, V, 3) metres, to validate with.
    """

    surface: Surface
    shapes: np.ndarray
    unseen: np.ndarray
