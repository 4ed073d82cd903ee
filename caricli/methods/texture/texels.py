"""Where a surface is in its texture."""

from copy import copy

import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.methods.texture.fill_unseen import FEATURES
from caricli.methods.texture.picture_view import SurfacePoints
from caricli.render.visibility.corner_mix import corner_mix
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Mesh
from caricli.template.template import Template


class Texels:
    """The N texels that show a surface of V vertices, and how these mix there.

    covered: (S, S) bool, where they are. owner: (S, S) the texel, from 0 to N - 1, that each place of the texture
    shows; beyond the islands the nearest. corners, weights: (N, 3) vertices that mix, int32, and how much, float32.
    """

    def __init__(self, head: Mesh, size: int) -> None:
        """head: Mesh with UVs, in any shape. size: texels, width and height of the texture. Raises InputError when the
        UVs cover none of them.
        """
        face, weights = uv_map(head, size)
        self.covered = face >= 0
        if not self.covered.any():
            raise InputError(f"expected UVs that cover some of {size} x {size} texels, found some that cover none")
        self.corners = head.faces[face[self.covered]].astype(np.int32)
        self.weights = weights[self.covered]
        self.count = len(head.vertices)
        numbers = np.zeros(self.covered.shape, int)
        numbers[self.covered] = np.arange(len(self.corners))
        self.owner = pad_texture(numbers, self.covered)

    @property
    def mix(self) -> sp.csr_matrix:
        """(N, V)."""
        return corner_mix(self.corners, self.weights, self.count)

    def part(self, rows: np.ndarray) -> "Texels":
        """Of the texels those of rows (N,) bool."""
        part = copy(self)
        part.corners = self.corners[rows]
        part.weights = self.weights[rows]
        return part

    def mirrored(self, mirror: np.ndarray) -> "Texels":
        """Where they are on the other side. mirror: (V,) vertices that face each other."""
        other = copy(self)
        other.corners = mirror.astype(np.int32)[self.corners]
        return other

    def points(self, vertices: SurfacePoints, shade: np.ndarray) -> tuple[SurfacePoints, np.ndarray]:
        """Points and shade (N, 3), of what they are at the vertices."""
        shares = [vertices.pockets, vertices.hidden, vertices.neck, vertices.scalp, vertices.ears]
        values = self.mix @ np.column_stack([vertices.places, vertices.normals, *shares, shade]).astype(np.float32)
        return SurfacePoints(values[:, :3], values[:, 3:6], *values[:, 6:11].T), values[:, 11:]

    def regions(self, head: Template) -> np.ndarray:
        """(S, S) int, 2 on the scalp, 1 on other plain skin, 0 elsewhere."""
        shares = self.mix @ np.column_stack([head.mask(*FEATURES), head.mask("scalp")]).astype(np.float32)
        regions = np.zeros(self.covered.shape, int)
        regions[self.covered] = np.where(shares[:, 0] > 0.01, 0, np.where(shares[:, 1] > 0.5, 2, 1))
        return regions
