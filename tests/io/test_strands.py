from dataclasses import replace

import numpy as np
import pygltflib
import pytest

from caricli.io.gltf.strands import EXTENSION, STRENGTH, strand_tangents
from caricli.io.gltf.write_gltf import shading_normals, write_gltf
from caricli.structures import Material, Mesh, Pictures, Rig

SIDE = 9


@pytest.fixture
def cap():
    """A bowl of hair whose picture is unrolled around its whorl."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE)))
    vertices = 0.1 * np.column_stack([x, y, 0.3 * (2 - x * x - y * y)])
    ids = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1).reshape(-1, 4)
    uvs = 0.5 + 0.4 * np.column_stack([x, y])
    mesh = Mesh(vertices.astype(np.float32), quads, uvs, quads.copy())
    hair = np.full(len(quads), Material.HAIR, np.int32)
    picture = np.full((4, 4, 3), 90, np.uint8)
    return Rig((), mesh, np.zeros((0, len(vertices), 3), np.float32), materials=hair, pictures=Pictures(hair=picture))


def test_tangents_run_around_the_whorl(cap):
    normals, _ = shading_normals(cap)
    everywhere = np.ones(len(cap.faces), bool)
    mirrored = replace(cap.mesh, uvs=cap.mesh.uvs * [-1, 1] + [1, 0])
    for mesh in (cap.mesh, mirrored):
        tangents = strand_tangents(mesh, everywhere, normals)
        assert tangents.dtype == np.float32 and set(tangents[:, 3]) == {1.0}
        np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-6)
        np.testing.assert_allclose((tangents[:, :3] * normals).sum(1), 0, atol=1e-6)
        inner = np.flatnonzero(np.linalg.norm(mesh.vertices[:, :2], axis=1) > 1e-6)
        around = np.cross([0.0, 0, 1], mesh.vertices[inner] * [1, 1, 0])
        around /= np.linalg.norm(around, axis=1, keepdims=True)
        assert (np.abs((tangents[inner, :3] * around).sum(1)) > 0.95).all()


def test_hair_with_a_picture_shines_across_strands(cap, tmp_path):
    write_gltf(tmp_path / "a.glb", cap)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    assert gltf.extensionsUsed == [EXTENSION] and gltf.meshes[0].primitives[0].attributes.TANGENT is not None
    assert gltf.materials[0].extensions == {EXTENSION: {"anisotropyStrength": STRENGTH}}


def test_hair_without_a_picture_has_no_strands(cap, tmp_path):
    write_gltf(tmp_path / "a.glb", replace(cap, pictures=Pictures()))
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    assert not gltf.extensionsUsed and gltf.meshes[0].primitives[0].attributes.TANGENT is None


def test_hair_is_shaded_as_the_skin_on_which_it_lies(cap):
    """A dented layer of hair, at most 1 mm above a smooth bowl of skin, which is 200 mm high."""
    count = len(cap.mesh.vertices)
    dents = np.random.default_rng(0).uniform(1e-4, 1e-3, count)
    dented = (cap.mesh.vertices + dents[:, None] * [0, 0, 1]).astype(np.float32)
    quads = np.concatenate([cap.mesh.polygons, cap.mesh.polygons + count])
    both = Mesh(np.concatenate([cap.mesh.vertices, dented]), quads)
    materials = np.repeat([Material.SKIN, Material.HAIR], len(quads) // 2).astype(np.int32)
    rig = Rig((), both, np.zeros((0, 2 * count, 3), np.float32), materials=materials)
    plain, _ = shading_normals(replace(rig, materials=None))
    normals, _ = shading_normals(rig)
    np.testing.assert_array_equal(normals[:count], plain[:count])
    away = {name: np.abs(each[count:] - each[:count]).max() for name, each in (("plain", plain), ("combed", normals))}
    assert away["combed"] < 0.5 * away["plain"]
