"""Faces of the morphable model drawn so that every colour has derivatives (portrait paper, section 3.1.2)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.morphable.coefficients import CoefficientLayout
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.texture.estimate_light import GAMMA
from caricli.models.morphable.model import MorphableModel
from caricli.render.visibility.rasterise import rasterise

LAMBERT = (1.0, *[2 / 3] * 3, *[1 / 4] * 5)
"""What a matt surface keeps of each spherical harmonic of the light (Ramamoorthi and Hanrahan 2001), over pi."""

GRAZING = 0.1
"""Cosine between a triangle and the picture under which it is too narrow to tell anything."""

DARKEST = 0.02
"""Linear light about which shade turns into a floor, so that the gamma curve keeps finite derivatives."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A batch of faces before the camera, differentiable by their coefficients.

    vertices: (B, V, 3) metres. rotation: (B, 3, 3) as Camera has it. placed: (B, V, 3) pixels and depth in pixels.
    shade: (B, V) factors by which light changes sRGB. colours: (B, V, 3) lit sRGB from 0, 1 is white.
    """

    vertices: torch.Tensor
    rotation: torch.Tensor
    placed: torch.Tensor
    shade: torch.Tensor
    colours: torch.Tensor


@dataclass(frozen=True, eq=False)
class Sight:
    """The N pixels of B pictures in which faces are seen from outside.

    picture, row, column, face: (N,) int64: which picture, where in it, which triangle; those of a picture together.
    """

    picture: torch.Tensor
    row: torch.Tensor
    column: torch.Tensor
    face: torch.Tensor

    def of(self, maps: torch.Tensor) -> torch.Tensor:
        """What the pixels have in maps (B, H, W, ...). Returns (N, ...)."""
        return maps[self.picture, self.row, self.column]


class Patch:
    """Part of the surface of a morphable model, drawn from coefficients (B, D) laid out as ``layout`` says.

    Pixels are ``scale * rotation[:2] @ (p - middle) + place``, where the middle is the mean of all vertices of the
    face; colours ``albedo * light ** (1 / GAMMA)``, light the nine harmonics of the normals in the camera's axes.
    """

    def __init__(
        self, model: MorphableModel, ids: np.ndarray, faces: np.ndarray, dtype: torch.dtype, device: Any = "cpu"
    ) -> None:
        """ids: (V,) vertices of the part. faces: (F, 3) numbers among them. dtype, device: of all that comes out."""
        self.layout = CoefficientLayout.of(model)

        def tensor(array: np.ndarray) -> torch.Tensor:
            return torch.as_tensor(array, dtype=dtype, device=device)

        def rows(basis: np.ndarray) -> torch.Tensor:
            return tensor(basis[:, ids].reshape(len(basis), -1))

        self.mean = tensor(model.mean[ids])
        self.basis = rows(model.basis)
        self.middle = tensor(model.mean.mean(0))
        self.middle_basis = tensor(model.basis.mean(1))
        self.albedo_mean = tensor(model.albedo.mean[ids])
        self.albedo_basis = rows(model.albedo.basis)
        self.faces = torch.as_tensor(faces.astype(np.int64), device=device)

    def pose(self, coefficients: torch.Tensor) -> Posed:
        """Place and light the faces of coefficients (B, D)."""
        parts = self.layout.parts(coefficients)
        latent = torch.cat([parts["identity"], parts["expression"]], -1)
        vertices = self.mean + (latent @ self.basis).unflatten(-1, self.mean.shape)
        rotation = head_rotations(parts["pose"][..., :3])
        middle = self.middle + latent @ self.middle_basis
        turned = (vertices - middle[:, None]) @ rotation.mT
        flat = torch.nn.functional.pad(parts["pose"][..., 3:5], (0, 1))
        placed = parts["pose"][..., 5, None, None] * turned + flat[:, None]
        albedo = self.albedo_mean + (parts["albedo"] @ self.albedo_basis).unflatten(-1, self.albedo_mean.shape)
        shade = light_factors(vertex_normals(turned, self.faces), parts["light"])
        return Posed(vertices, rotation, placed, shade, albedo * shade[..., None])

    def paint(self, posed: Posed, sight: Sight) -> torch.Tensor:
        """(N, 3) sRGB colours of the pixels of a Sight, interpolated between the corners of their triangles.

        Which triangle a pixel sees has no derivative; where in it the pixel is, has.
        """
        corners = self.faces[sight.face]
        batch = sight.picture[:, None]
        weights = barycentric(posed.placed[batch, corners][..., :2], torch.stack([sight.column, sight.row], -1))
        return (weights[..., None] * posed.colours[batch, corners]).sum(1)


class MorphableRenderer(Patch):
    """The whole surface of a morphable model, and what pictures of it show."""

    def __init__(self, model: MorphableModel, dtype: torch.dtype = torch.float32, device: Any = "cpu") -> None:
        """model: MorphableModel. dtype, device: of all that comes out."""
        super().__init__(model, np.arange(len(model.mean)), model.template.faces, dtype, device)
        self.model = model

    def anchors(self, posed: Posed, count: int) -> torch.Tensor:
        """(B, count) int64 vertices that the first landmarks stand on, those of the jaw on the outline."""
        shapes = zip(posed.vertices.detach().cpu().numpy(), posed.rotation.detach().cpu().numpy(), strict=True)
        ids = [landmark_vertices(vertices, turn, self.model.template, count) for vertices, turn in shapes]
        return torch.as_tensor(np.stack(ids).astype(np.int64), device=posed.placed.device)

    def landmarks(self, posed: Posed, anchors: torch.Tensor) -> torch.Tensor:
        """(B, L, 2) pixels of anchors (B, L)."""
        return posed.placed.gather(1, anchors[..., None].expand(-1, -1, 3))[..., :2]

    def look(self, posed: Posed, height: int, width: int) -> Sight:
        """Which pixels of pictures of a size see the faces.

        Triangles that are seen from inside, or hardly seen, hide what is behind them, and are no sight.
        """
        faces = self.model.template.faces
        pixels = []
        for number, placed in enumerate(posed.placed.detach().cpu().numpy().astype(float)):
            normals = triangle_normals(placed, faces)
            toward = -normals[:, 2] > GRAZING * np.linalg.norm(normals, axis=1)
            seen = rasterise(placed, faces, width, height).face
            row, column = np.nonzero((seen >= 0) & toward[seen])
            pixels.append(np.stack([np.full(len(row), number), row, column, seen[row, column]]))
        columns = torch.as_tensor(np.concatenate(pixels, 1).astype(np.int64), device=posed.placed.device)
        return Sight(*columns)


def head_rotations(angles: torch.Tensor) -> torch.Tensor:
    """``head_rotation`` (..., 3, 3) of pitch, yaw and roll (..., 3), radians."""
    pitch, yaw, roll = angles.unbind(-1)
    zero = torch.zeros_like(pitch)
    one = torch.ones_like(pitch)

    def rows(*values: torch.Tensor) -> torch.Tensor:
        return torch.stack(values, -1).unflatten(-1, (3, 3))

    about_x = rows(one, zero, zero, zero, pitch.cos(), -pitch.sin(), zero, pitch.sin(), pitch.cos())
    about_y = rows(yaw.cos(), zero, yaw.sin(), zero, one, zero, -yaw.sin(), zero, yaw.cos())
    about_z = rows(roll.cos(), -roll.sin(), zero, roll.sin(), roll.cos(), zero, zero, zero, one)
    return about_z @ about_x @ about_y * angles.new_tensor([1.0, -1.0, -1.0])


def vertex_normals(vertices: torch.Tensor, faces: torch.Tensor) -> torch.Tensor:
    """Unit normals (B, V, 3) of vertices (B, V, 3), means of those of the triangles around, by their areas."""
    corners = vertices[:, faces]
    normals = torch.linalg.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    total = torch.zeros_like(vertices)
    for k in range(3):
        total = total.index_add(1, faces[:, k], normals)
    return torch.nn.functional.normalize(total, dim=-1, eps=1e-20)


def light_factors(normals: torch.Tensor, light: torch.Tensor) -> torch.Tensor:
    """Factors (B, V) of sRGB by normals (B, V, 3) in the axes of the nine harmonics (B, 9) of the light."""
    kept = light.new_tensor(LAMBERT) * light
    received = (light_harmonics(normals) * kept[:, None]).sum(-1)
    return ((received + (received**2 + DARKEST**2).sqrt()) / 2) ** (1 / GAMMA)


def light_harmonics(normals: torch.Tensor) -> torch.Tensor:
    """`harmonics` (..., 9) of unit normals (..., 3), with derivatives."""
    x, y, z = normals.unbind(-1)
    first = (3 / (4 * np.pi)) ** 0.5
    second = (15 / (4 * np.pi)) ** 0.5
    one = torch.full_like(x, (1 / (4 * np.pi)) ** 0.5)
    squares = [second * x * y, second * y * z, (5 / (16 * np.pi)) ** 0.5 * (3 * z * z - 1)]
    return torch.stack(
        [one, first * x, first * y, first * z, *squares, second * x * z, second / 2 * (x * x - y * y)], -1
    )


def barycentric(corners: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
    """Weights (N, 3) of the corners (N, 3, 2) of triangles at points (N, 2)."""
    a, b, c = (corners - points[:, None]).unbind(1)

    def area(p: torch.Tensor, q: torch.Tensor) -> torch.Tensor:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    areas = torch.stack([area(b, c), area(c, a), area(a, b)], -1)
    return areas / areas.sum(-1, keepdim=True)
