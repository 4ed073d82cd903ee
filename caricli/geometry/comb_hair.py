"""Hair that is shaded as hair: calmly, and where it lies thin on the skin as this."""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.smooth_step import smooth_step
from caricli.geometry.vertex_neighbours import vertex_neighbours

ROUNDS = 6
"""How often normals are evened with those around: the dents and edges of a shell are not those of hair."""

THIN = 0.03
"""Of the skin's height: hair that is thinner is shaded more and more as the skin below."""

MATT = 0.05
"""Of the skin's height: hair that is thinner shines less and less, as cropped hair, which is skin that is painted."""

ALIKE = 0.6
"""Cosine between the normals of hair and skin from which on the one lies on the other; behind an ear it does not."""


@dataclass(frozen=True, eq=False)
class CombedHair:
    """How a mesh with hair is shaded, which it keeps as it moves.

    at: (H,) int64, the vertices of the hair. around: (H, H) sparse, the sum with those around. below: (H, V) sparse,
    the place of the skin that is nearest to each. lying: (H,) 0 to 1, how far each is shaded as that. shine: (V,) 0 to
    1, how much strands shine; 1 beside hair.
    """

    at: np.ndarray
    around: sp.csr_matrix
    below: sp.csr_matrix
    lying: np.ndarray
    shine: np.ndarray

    def normals(self, normals: np.ndarray) -> np.ndarray:
        """Unit normals (V, 3) of the mesh's surface as those that it is shaded with."""
        lying = self.lying[:, None]
        own = _evened(normals[self.at], self.around)
        shaded = np.array(normals)
        shaded[self.at] = _unit((1 - lying) * own + lying * _unit(self.below @ normals))
        return shaded


def comb_hair(
    vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, hair: np.ndarray, skin: np.ndarray
) -> CombedHair | None:
    """CombedHair of a mesh at rest; None where it has no hair, or no skin below it.

    vertices: (V, 3), any unit, +y up. faces: (F, 3). normals: (V, 3), of unit length. hair, skin: (F,) bool, which
    triangles are one.
    """
    if not (hair.any() and skin.any()):
        return None
    vertices = np.ascontiguousarray(vertices, float)
    at, strands = np.unique(faces[hair], return_inverse=True)
    adjacency, _ = vertex_neighbours(strands.reshape(-1, 3), len(at))
    around = sp.csr_matrix(adjacency + sp.eye(len(at)))
    ground = faces[skin].astype(np.int64)
    _, triangle, places = igl.point_mesh_squared_distance(vertices[at], vertices, ground)
    corners = ground[triangle]
    shares = igl.barycentric_coordinates(places, *(vertices[corners[:, k]] for k in range(3)))
    # A triangle without an area has no places.
    shares = np.where(np.isfinite(shares), shares, 1 / 3)
    rows = np.repeat(np.arange(len(at)), 3)
    below = sp.csr_matrix((shares.ravel(), (rows, corners.ravel())), (len(at), len(vertices)))
    under = _unit(below @ normals)
    height = np.ptp(vertices[ground.ravel(), 1])
    thick = ((vertices[at] - places) * under).sum(1) / (height or 1)
    alike = smooth_step((_evened(normals[at], around) * under).sum(1), 0, ALIKE)
    shine = np.ones(len(vertices))
    shine[at] = 1 - alike * (1 - smooth_step(thick, 0, MATT))
    return CombedHair(at, around, below, alike * (1 - smooth_step(thick, 0, THIN)), shine)


def _evened(normals: np.ndarray, around: sp.csr_matrix) -> np.ndarray:
    for _ in range(ROUNDS):
        normals = _unit(around @ normals)
    return normals


def _unit(normals: np.ndarray) -> np.ndarray:
    """Of unit length, but for (0, 0, 0)."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0, length, 1)
