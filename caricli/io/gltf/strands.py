"""Hair that shines across its strands: KHR_materials_anisotropy."""

import numpy as np

from caricli.structures import Mesh, Rig
from caricli.structures.materials import Material

EXTENSION = "KHR_materials_anisotropy"

STRENGTH = 0.8
"""How much farther highlights reach across strands than along them, from 0 to 1."""

ROUGHNESS = 0.55
"""Of hair along its strands."""

_MIDDLE = 0.5
"""Of the picture of hair, from whose middle strands run outwards."""

_LEAST = 1e-12
"""Length below which a way is none."""


def has_strands(rig: Rig) -> bool:
    """Whether a rig has hair with a picture, whose strands run outwards from its middle."""
    pictured = rig.pictures.hair is not None and rig.mesh.uvs is not None
    return pictured and bool((rig.triangle_materials == Material.HAIR).any())


def add_strands(document: dict, number: int) -> None:
    """Let a material of a document shine across strands. number: the material."""
    material = document["materials"][number]
    material["pbrMetallicRoughness"]["roughnessFactor"] = ROUGHNESS
    material.setdefault("extensions", {})[EXTENSION] = {"anisotropyStrength": STRENGTH}
    document.setdefault("extensionsUsed", []).append(EXTENSION)


def strand_tangents(mesh: Mesh, hair: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(V, 4) float32 unit tangents across the strands of hair, as glTF has them; any across the normal elsewhere.

    mesh: with UVs. hair: (F,) bool, which triangles are hair. normals: (V, 3) of unit length.
    """
    assert mesh.uvs is not None
    corners = mesh.faces[hair]
    a, b, c = np.swapaxes(mesh.vertices[corners], 0, 1)
    places = mesh.uvs[mesh.uv_faces[hair]]
    first, second = np.swapaxes(places[:, 1:] - places[:, :1], 0, 1)
    twice = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])[:, None, None]
    x, y = np.moveaxis(places - _MIDDLE, -1, 0)[..., None]
    # What moves the place in the picture off its middle, at every corner.
    outwards = (x * second[:, None, 1:] - y * second[:, None, :1]) * (b - a)[:, None]
    outwards = (outwards + (y * first[:, None, :1] - x * first[:, None, 1:]) * (c - a)[:, None]) * np.sign(twice)
    outwards /= np.maximum(np.linalg.norm(outwards, axis=-1, keepdims=True), _LEAST)
    along = np.zeros(mesh.vertices.shape)
    np.add.at(along, corners, outwards)
    across = np.cross(normals, along)
    # At the whorl, where strands run all ways, and beside the hair.
    lost = np.linalg.norm(across, axis=1) < _LEAST
    across[lost] = np.cross(normals[lost], np.eye(3)[np.abs(normals[lost]).argmin(1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.column_stack([across, np.ones(len(across))]).astype(np.float32)
