"""What a mesh is painted with when it is drawn."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.structures import Material, Mesh, Pictures, Rig
from caricli.structures.pictures import PICTURED

_SMALLEST = 1e-9
_FINE = 1.25  # texels along a pixel that it may still have
_COARSEST = 16  # texels: a picture of a smaller side has no colours left


@dataclass(frozen=True, eq=False)
class Coat:
    """Pictures on the triangles of a mesh.

    uvs: (T, 2), origin at the bottom left. uv_faces: (F, 3) indices into them. materials: (F,) Material.
    pictures: Pictures; a material without one keeps the colour of the mesh.
    """

    uvs: np.ndarray
    uv_faces: np.ndarray
    materials: np.ndarray
    pictures: Pictures

    def cut(self, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The mesh with its vertices doubled along seams, where they have two places in a picture.

        faces: (F, 3) of the mesh. Returns (W,) numbers of vertices, (F, 3) faces of them, and their places (W, 3) in
        the pictures: u, v, and the Material.
        """
        materials = np.repeat(self.materials[:, None], 3, axis=1)
        corners = np.stack([faces, self.uv_faces, materials], axis=-1).reshape(-1, 3).astype(np.int64)
        key = (corners[:, 0] * len(self.uvs) + corners[:, 1]) * len(Material) + corners[:, 2]
        _, first, number = np.unique(key, return_index=True, return_inverse=True)
        at, uv, material = corners[first].T
        return at, number.reshape(-1, 3).astype(np.int32), np.column_stack([self.uvs[uv], material])

    def shrunk(self, points: np.ndarray, faces: np.ndarray, ball: float = 0.0) -> "Coat":
        """The same in pictures whose texels are about as large as pixels: smaller ones would sparkle.

        points: (V, 3), pixels and depth. faces: (F, 3). ball: pixels, radius of eyeballs beside the mesh, which are
        drawn where it has none of its own.
        """
        pictures = []
        for picture, (chosen, texels) in zip(self.pictures, self._painted, strict=True):
            if picture is not None:
                rate = np.sqrt(texels / max(_area(points[faces[chosen]]), _SMALLEST))
                if not len(chosen):
                    rate = picture.shape[0] / max(2 * np.pi * ball, _SMALLEST)
                picture = _shrunk(picture, min(rate, min(picture.shape[:2]) / _COARSEST))
            pictures.append(picture)
        return replace(self, pictures=Pictures(*pictures))

    @cached_property
    def _painted(self) -> list[tuple[np.ndarray, float]]:
        """Of every picture the triangles that have it, and their area in it, texels."""
        painted = []
        for material, picture in zip(PICTURED, self.pictures, strict=True):
            height, width = (0, 0) if picture is None else picture.shape[:2]
            chosen = np.flatnonzero(self.materials == material)
            painted.append((chosen, _area(self.uvs[self.uv_faces[chosen]] * [width, height])))
        return painted


def mesh_coat(mesh: Mesh, pictures: Pictures, materials: np.ndarray | None = None) -> Coat | None:
    """The Coat of a mesh, or None where it is skin alone without UVs or a picture.

    materials: (F,) Material of its triangles; skin where there are none.
    """
    if materials is None and (mesh.uvs is None or not pictures):
        return None
    materials = np.full(len(mesh.faces), Material.SKIN) if materials is None else materials
    if mesh.uvs is None:
        return Coat(np.zeros((1, 2)), np.zeros_like(mesh.faces), materials, Pictures())
    return Coat(mesh.uvs, mesh.uv_faces, materials, pictures)


def rig_coat(rig: Rig) -> Coat | None:
    """The Coat of a rig, or None where it has no pictures."""
    return mesh_coat(rig.mesh, rig.pictures, rig.triangle_materials)


def _area(corners: np.ndarray) -> float:
    """Sum of the areas of triangles (F, 3, 2 or 3)."""
    along = corners[:, 1] - corners[:, 0]
    across = corners[:, 2] - corners[:, 0]
    gram = (along**2).sum(1) * (across**2).sum(1) - (along * across).sum(1) ** 2
    return float(np.sqrt(np.maximum(gram, 0)).sum() / 2)


def _shrunk(picture: np.ndarray, times: float) -> np.ndarray:
    """A picture so many times smaller, or itself where that is hardly a difference."""
    if times < _FINE:
        return picture
    import cv2

    height, width = (max(round(side / times), 1) for side in picture.shape[:2])
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
