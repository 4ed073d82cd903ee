import base64
import copy
import io
import json
import shutil
import struct
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pygltflib
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import caricli
from caricli.errors import InputError, OutputError
from caricli.io.gltf.read_clips import read_clips
from caricli.io.gltf.read_gltf import read_gltf, read_gltf_mesh
from caricli.io.gltf.write_gltf import shading_normals, write_gltf
from caricli.io.image import png_bytes
from caricli.io.rig import read_rig, write_rig
from caricli.structures import Animation, Material, Mesh, Mood, Pictures, Rig
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.change_atlas import ChangeAtlas

VALIDATOR = Path(caricli.__file__).parents[1] / "tests" / "gltf_validator"
DTYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def plain(rig):
    return Rig(rig.names, Mesh(rig.neutral, rig.faces), rig.deltas)


def still(rig):
    return replace(rig, names=(), deltas=rig.deltas[:0])


def haired(rig, moved=0.0):
    """The rig whose last quads are hair on vertices of their own."""
    polygons, count = rig.mesh.polygons, len(rig.neutral)
    last = np.unique(polygons[-8:])
    number = np.arange(count)
    number[last] = count + np.arange(len(last))
    deltas = np.concatenate([rig.deltas, np.full((len(rig.names), len(last), 3), moved, np.float32)], axis=1)
    mesh = rig.mesh
    uv_polygons = None if mesh.uv_polygons is None else np.concatenate([mesh.uv_polygons, mesh.uv_polygons[-8:]])
    return replace(
        rig,
        mesh=Mesh(
            np.concatenate([rig.neutral, 1.1 * rig.neutral[last]]),
            np.concatenate([polygons, number[polygons[-8:]]]),
            mesh.uvs,
            uv_polygons,
        ),
        deltas=deltas,
        materials=np.concatenate([rig.materials, np.full(8, Material.HAIR)]).astype(np.int32),
        pictures=replace(rig.pictures, hair=rig.pictures.skin),
    )


def toothed(rig):
    """The rig whose eyes are teeth."""
    return replace(rig, materials=np.where(rig.materials == Material.EYE, Material.TEETH, rig.materials))


def moody(rig):
    """The rig with two moods."""
    skin = rig.pictures.skin
    return replace(rig, moods=(Mood("sad", skin // 2), Mood("ü 微笑", 255 - skin)))


def changing(rig):
    """The rig with what its expressions do to its skin."""
    picture = np.random.default_rng(8).integers(0, 255, (16, 16, 3), np.uint8)
    return replace(rig, changes=ChangeAtlas(picture, 4, 4, (0.1, 0.25, 0.75, 0.9), 0.5, 0.25))


def grid(side, names=("bump",)):
    """A square of side x side vertices and quads, with a bump."""
    row, column = (a.ravel() for a in np.mgrid[: side - 1, : side - 1])
    first = row * side + column
    polygons = np.stack([first, first + 1, first + side + 1, first + side], axis=1).astype(np.int32)
    y, x = np.mgrid[:side, :side] / (5 * side)
    neutral = np.stack([x.ravel(), y.ravel(), np.zeros(side**2)], axis=1).astype(np.float32)
    deltas = np.zeros((len(names), side**2, 3), np.float32)
    deltas[0, side + 1] = [0, 0, 0.01]
    return Rig(names, Mesh(neutral, polygons), deltas)


def movement(rig, frames=7):
    generator = np.random.default_rng(5)
    turns = generator.normal(0, 1, (frames, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return Animation(np.arange(frames) / 30, generator.random((frames, len(rig.names))), turns)


@pytest.fixture(scope="module")
def head_rig(head):
    """All actions of the open head, with what is noise at rest."""
    deltas = np.where(np.abs(head.actions).max(2, keepdims=True) > 1e-6, head.actions, 0).astype(np.float32)
    mesh = Mesh(head.evaluate().astype(np.float32), head.polygons, head.uvs, head.uv_polygons)
    return Rig(head.action_names, mesh, deltas)


@pytest.fixture(scope="module")
def subdivided_rig(head_rig):
    from caricli.geometry.subdivide import subdivide

    coarse = head_rig.mesh
    weights, polygons = subdivide(coarse.polygons, len(coarse.vertices), 1, 10**5)
    uv_weights, uv_polygons = subdivide(coarse.uv_polygons, len(coarse.uvs), 1, 10**5)
    vertices = (weights @ coarse.vertices).astype(np.float32)
    kept = [head_rig.names.index(name) for name in ("jawOpen", "eyeBlinkLeft", "mouthPucker")]
    return Rig(
        tuple(head_rig.names[k] for k in kept),
        Mesh(vertices, polygons, uv_weights @ coarse.uvs, uv_polygons),
        np.stack([weights @ head_rig.deltas[k] for k in kept]).astype(np.float32),
    )


def kinds(full, head, subdivided):
    """Every kind of file that is written: name to rig and options."""
    turning = movement(full)
    return {
        "plain": (plain(full), {}),
        "plain sparse": (plain(full), {"sparse": True}),
        "eyes, seams and pictures": (full, {}),
        "eyes, seams and pictures, sparse": (full, {"sparse": True}),
        "eyes without pictures": (replace(full, pictures=Pictures()), {}),
        "a picture without UVs": (replace(full, mesh=Mesh(full.neutral, full.mesh.polygons)), {}),
        "only eyes": (replace(full, materials=np.full_like(full.materials, Material.EYE)), {}),
        "animated": (full, {"animation": turning}),
        "animated sparse": (full, {"animation": turning, "sparse": True}),
        "one frame, no rotation": (full, {"animation": Animation([0.0], turning.weights[:1])}),
        "teeth": (toothed(full), {}),
        "hair": (haired(full), {}),
        "moods": (moody(full), {}),
        "changes": (changing(full), {}),
        "changes, moods, sparse": (changing(moody(full)), {"sparse": True}),
        "changes without UVs": (replace(changing(full), mesh=Mesh(full.neutral, full.mesh.polygons)), {}),
        "moods, hair, teeth, sparse": (moody(toothed(haired(full))), {"sparse": True}),
        "moods without UVs": (replace(moody(full), mesh=Mesh(full.neutral, full.mesh.polygons)), {}),
        "moods without skin": (replace(moody(full), materials=np.full_like(full.materials, Material.EYE)), {}),
        "hair, sparse, animated": (haired(full), {"sparse": True, "animation": turning}),
        "hair that keeps still": (still(haired(full)), {}),
        "hair that moves": (haired(full, 0.01), {}),
        "all but hair is lashes": (replace(haired(full), materials=np.maximum(haired(full).materials, 5)), {}),
        "nothing moves": (replace(full, deltas=0 * full.deltas), {}),
        "nothing moves, sparse": (replace(full, deltas=0 * full.deltas), {"sparse": True}),
        "keeps still": (still(full), {}),
        "keeps still, sparse": (still(full), {"sparse": True}),
        "keeps still, plain": (still(plain(full)), {}),
        "keeps still, turns": (still(full), {"animation": replace(turning, weights=turning.weights[:, :0])}),
        "keeps still, animated": (still(full), {"animation": Animation([0.0], np.zeros((1, 0)))}),
        "head keeps still": (still(head), {}),
        "no area": (replace(plain(full), mesh=Mesh(np.float32([1, 0, 0]) * full.neutral, full.faces)), {}),
        "loose vertices": (replace(plain(full), mesh=Mesh(full.neutral, full.faces[:-20])), {}),
        "other names": (replace(plain(full), names=("ü 微笑", 'a"b', "c\\d", "e\nf")), {}),
        "32-bit indices": (grid(257), {"sparse": True}),
        "head": (head, {}),
        "head sparse": (head, {"sparse": True}),
        "head animated": (head, {"animation": movement(head)}),
        "subdivided": (subdivided, {}),
        "subdivided sparse": (subdivided, {"sparse": True}),
    }


def validated(paths):
    """The issues that Khronos' validator sees in files, (severity, code, pointer) each."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    if not (VALIDATOR / "node_modules" / "gltf-validator").is_dir():
        pytest.skip("npm ci in tests/gltf_validator has not been run")
    done = subprocess.run(["node", VALIDATOR / "validate.mjs", *paths], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    reports = json.loads(done.stdout)
    assert len(reports) == len(paths)
    return [[(m["severity"], m["code"], m["pointer"]) for m in r["issues"]["messages"]] for r in reports]


def test_khronos_validator_has_nothing_to_say_of_any_kind(full_rig, head_rig, subdivided_rig, tmp_path):
    files = {}
    for number, (kind, (rig, options)) in enumerate(kinds(full_rig, head_rig, subdivided_rig).items()):
        files[kind] = tmp_path / f"{number}.glb"
        write_gltf(files[kind], rig, **options)
    issues = dict(zip(files, validated(files.values()), strict=True))
    # UVs without a picture are there for the artist who will paint one.
    unused = {(2, "UNUSED_OBJECT", f"/meshes/0/primitives/{k}/attributes/TEXCOORD_0") for k in range(2)}
    # The validator knows tangents for maps of normals, not for strands of hair.
    hair = [(mesh, primitive) for mesh in range(2) for primitive in range(4)]
    unused |= {(2, "UNUSED_MESH_TANGENT", f"/meshes/{m}/primitives/{p}/attributes/TANGENT") for m, p in hair}
    # Programs that do not know the changes have no use for them.
    unused |= {(2, "UNUSED_OBJECT", f"/textures/{k}") for k in range(5)}
    assert {kind: set(found) - unused for kind, found in issues.items() if set(found) - unused} == {}


def test_khronos_validator_sees_faults(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["accessors"][0]["max"][0] += 1
    document["meshes"][0]["weights"].pop()
    put_together(tmp_path / "a.glb", document, binary)
    (issues,) = validated([tmp_path / "a.glb"])
    assert {"ACCESSOR_MAX_MISMATCH", "MESH_INVALID_WEIGHTS_COUNT"} <= {code for severity, code, _ in issues}
    assert {severity for severity, _, _ in issues} == {0}


def taken_apart(path):
    """Document and binary chunk of a GLB, as the specification lays them out."""
    data = path.read_bytes()
    magic, version, length, text_length, text_kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, text_kind) == (b"glTF", 2, len(data), b"JSON")
    size, kind = struct.unpack_from("<I4s", data, 20 + text_length)
    assert kind == b"BIN\0" and text_length % 4 == size % 4 == 0 and 28 + text_length + size == length
    return json.loads(data[20 : 20 + text_length]), data[28 + text_length :]


def put_together(path, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def values(gltf, index):
    """An accessor's values by pygltflib's reading of the document."""
    accessor, blob = gltf.accessors[index], gltf.binary_blob()
    width = WIDTHS[accessor.type]

    def part(view, offset, dtype, count, width):
        start = gltf.bufferViews[view].byteOffset + (offset or 0)
        return np.frombuffer(blob, dtype, count * width, start).reshape(count, width)

    dtype = DTYPES[accessor.componentType]
    array = np.zeros((accessor.count, width), dtype)
    if accessor.bufferView is not None:
        array[:] = part(accessor.bufferView, accessor.byteOffset, dtype, accessor.count, width)
    if accessor.sparse is not None:
        places, given = accessor.sparse.indices, accessor.sparse.values
        where = part(places.bufferView, places.byteOffset, DTYPES[places.componentType], accessor.sparse.count, 1)[:, 0]
        array[where] = part(given.bufferView, given.byteOffset, dtype, accessor.sparse.count, width)
    return array


def sources(gltf, primitive):
    return values(gltf, primitive.attributes._SOURCE_VERTEX)[:, 0].astype(int)


def test_less_light_comes_to_teeth_the_farther_back_they_are(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", toothed(full_rig))
    gltf = pygltflib.GLTF2().load(str(tmp_path / "a.glb"))
    skin, teeth = gltf.meshes[0].primitives
    assert skin.attributes.COLOR_0 is None
    light = values(gltf, teeth.attributes.COLOR_0)
    from_the_back = light[np.argsort(values(gltf, teeth.attributes.POSITION)[:, 2])]
    assert (np.diff(from_the_back, axis=0) >= 0).all()
    assert from_the_back[0, 0] == pytest.approx(0.1)
    assert (from_the_back[-1] == 1).all()


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("name", ["full_rig", "head_rig", "subdivided_rig"])
def test_pygltflib_reads_what_the_npz_holds(name, sparse, request, tmp_path):
    write_gltf(tmp_path / "a.glb", request.getfixturevalue(name), sparse=sparse)
    write_rig(tmp_path / "a.npz", request.getfixturevalue(name))
    rig, gltf = read_rig(tmp_path / "a.npz"), pygltflib.GLTF2.load(tmp_path / "a.glb")
    assert (len(gltf.scenes), len(gltf.nodes), len(gltf.meshes), gltf.extensionsUsed) == (1, 1, 1, [])
    assert gltf.asset.generator == f"caricli {caricli.__version__}"
    (mesh,) = gltf.meshes
    assert tuple(mesh.extras["targetNames"]) == rig.names and mesh.weights == [0] * len(rig.names)
    seen = set()
    for primitive in mesh.primitives:
        source = sources(gltf, primitive)
        seen |= {*source.tolist()}
        np.testing.assert_allclose(values(gltf, primitive.attributes.POSITION), rig.neutral[source], rtol=0, atol=1e-6)
        normals = values(gltf, primitive.attributes.NORMAL)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
        assert len(primitive.targets) == len(rig.names)
        for target, delta in zip(primitive.targets, rig.deltas, strict=True):
            np.testing.assert_allclose(values(gltf, target["POSITION"]), delta[source], rtol=0, atol=1e-6)
            assert values(gltf, target["NORMAL"]).shape == normals.shape
        for index in (primitive.attributes.POSITION, *(target["POSITION"] for target in primitive.targets)):
            accessor, array = gltf.accessors[index], values(gltf, index)
            np.testing.assert_array_equal(np.float32([accessor.min, accessor.max]), [array.min(0), array.max(0)])
    assert seen == set(range(len(rig.neutral)))


def test_the_head_has_all_names_of_arkit(head_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", head_rig)
    names = pygltflib.GLTF2.load(tmp_path / "a.glb").meshes[0].extras["targetNames"]
    assert len(names) == 52 and set(names) == set(ARKIT_NAMES)


def test_hair_is_a_node_below_the_head_and_comes_back_with_it(full_rig, tmp_path):
    rig = haired(full_rig)
    write_gltf(tmp_path / "a.glb", rig, animation=movement(rig))
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    assert [node.name for node in gltf.nodes] == ["head", "hair"] and gltf.nodes[0].children == [1]
    assert gltf.scenes[0].nodes == [0] and not gltf.meshes[1].primitives[0].targets
    assert {channel.target.node for channel in gltf.animations[0].channels} == {0}
    back = read_gltf(tmp_path / "a.glb")
    np.testing.assert_array_equal(back.neutral, rig.neutral)
    np.testing.assert_array_equal(back.deltas, rig.deltas)
    np.testing.assert_array_equal(back.faces, rig.faces)
    np.testing.assert_array_equal(back.triangle_materials, rig.triangle_materials)
    assert back.pictures.same(rig.pictures)
    np.testing.assert_array_equal(read_gltf_mesh(tmp_path / "a.glb").faces, rig.faces)
    write_gltf(tmp_path / "b.glb", haired(full_rig, 0.01))
    assert [node.name for node in pygltflib.GLTF2.load(tmp_path / "b.glb").nodes] == ["head"]


def test_hair_that_another_program_moved_is_where_it_was_moved(full_rig, tmp_path):
    rig = haired(full_rig)
    write_gltf(tmp_path / "a.glb", rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["nodes"][0]["translation"] = [5, 5, 5]
    document["nodes"][1] |= {"translation": [0, 1, 0], "rotation": [0, 1, 0, 0], "scale": [2, 2, 2]}
    put_together(tmp_path / "b.glb", document, binary)
    back = read_gltf(tmp_path / "b.glb")
    hair = np.unique(rig.faces[rig.triangle_materials == Material.HAIR])
    expected = rig.neutral.copy()
    expected[hair] = rig.neutral[hair] * [-2, 2, -2] + [0, 1, 0]
    np.testing.assert_allclose(back.neutral, expected, atol=1e-6)
    np.testing.assert_array_equal(back.faces, rig.faces)
    document["nodes"][0]["children"] = [7]
    put_together(tmp_path / "c.glb", document, binary)
    with pytest.raises(InputError, match="expected the number of one of 2 nodes"):
        read_gltf(tmp_path / "c.glb")


def test_hair_that_another_program_mirrored_is_not_inside_out(full_rig, tmp_path):
    rig = haired(full_rig)
    write_gltf(tmp_path / "a.glb", rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["nodes"][1]["scale"] = [-1, 1, 1]
    put_together(tmp_path / "b.glb", document, binary)
    back = read_gltf(tmp_path / "b.glb").mesh
    hair = rig.triangle_materials == Material.HAIR
    np.testing.assert_array_equal(back.faces, np.where(hair[:, None], rig.faces[:, ::-1], rig.faces))
    corners = rig.mesh.uvs[rig.mesh.uv_faces]
    expected = np.where(hair[:, None, None], corners[:, ::-1], corners)
    np.testing.assert_allclose(back.uvs[back.uv_faces], expected, atol=1e-6)


def test_hair_comes_back_without_source_vertices_and_with_blenders_numbers(full_rig, tmp_path):
    rig = haired(full_rig)
    write_gltf(tmp_path / "a.glb", rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            del primitive["attributes"]["_SOURCE_VERTEX"]
    for material in document["materials"]:
        material["name"] += ".001"
    put_together(tmp_path / "b.glb", document, binary)
    back = read_gltf(tmp_path / "b.glb")
    np.testing.assert_array_equal(back.neutral[back.faces], rig.neutral[rig.faces])
    np.testing.assert_array_equal(back.triangle_materials, rig.triangle_materials)
    assert back.pictures.same(rig.pictures) and back.names == rig.names
    document["materials"][-1]["name"] = "glasses"
    put_together(tmp_path / "c.glb", document, binary)
    assert len(read_gltf(tmp_path / "c.glb").faces) == len(full_rig.faces)


def test_a_head_goes_before_the_hair_below_it_that_was_written_first(full_rig, tmp_path):
    rig = still(haired(full_rig))
    write_gltf(tmp_path / "a.glb", rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["meshes"].reverse()
    document["nodes"] = [{"name": "hair", "mesh": 0}, {"name": "head", "mesh": 1, "children": [0]}]
    document["scenes"][0]["nodes"] = [1]
    put_together(tmp_path / "b.glb", document, binary)
    np.testing.assert_array_equal(read_gltf(tmp_path / "b.glb").faces, rig.faces)
    np.testing.assert_array_equal(read_gltf_mesh(tmp_path / "b.glb").faces, rig.faces)


def taken_into_meshes(folder, rig, named=True, sourced=True):
    """A document in which every primitive of a rig is the mesh of a node of its own, the eyes first, and its bytes."""
    write_gltf(folder / "a.glb", rig)
    document, binary = taken_apart(folder / "a.glb")
    meshes = [mesh | {"primitives": [each]} for mesh in document["meshes"] for each in mesh["primitives"]]
    document["meshes"] = [meshes[1], meshes[0], *meshes[2:]]
    for mesh in document["meshes"]:
        mesh.pop("extras" if not named else "", None)
        mesh["primitives"][0]["attributes"].pop("_SOURCE_VERTEX" if not sourced else "", None)
    document["nodes"] = [{"mesh": number} for number in range(len(meshes))]
    document["nodes"].append({"children": [*range(len(meshes))], "scale": [2, 2, 2], "translation": [0, 5, 0]})
    document["scenes"] = [{"nodes": [len(meshes)]}]
    return document, binary


@pytest.mark.parametrize("named", [True, False])
def test_a_head_of_which_parts_are_meshes_of_their_own_is_read_whole(full_rig, tmp_path, named):
    rig = haired(full_rig)
    put_together(tmp_path / "b.glb", *taken_into_meshes(tmp_path, rig, named))
    back = read_gltf(tmp_path / "b.glb")
    assert (back.names == rig.names) == named
    np.testing.assert_allclose(back.neutral, 2 * rig.neutral, rtol=1e-6)
    np.testing.assert_allclose(back.deltas, 2 * rig.deltas, rtol=1e-6)
    np.testing.assert_array_equal(np.sort(back.faces, axis=0), np.sort(rig.faces, axis=0))
    assert back.pictures.same(rig.pictures)
    assert sorted(back.triangle_materials) == sorted(rig.triangle_materials)
    np.testing.assert_array_equal(read_gltf_mesh(tmp_path / "b.glb").faces, back.faces)


def test_parts_that_another_program_made_meshes_of_their_own_are_read_with_the_head(full_rig, tmp_path):
    rig = haired(full_rig)
    document, binary = taken_into_meshes(tmp_path, rig, sourced=False)
    eyes = document["meshes"][0]
    name = eyes["extras"]["targetNames"][-1]
    eyes["extras"] = {"targetNames": [name]}
    eyes["primitives"][0]["targets"] = eyes["primitives"][0]["targets"][-1:]
    put_together(tmp_path / "b.glb", document, binary)
    back = read_gltf(tmp_path / "b.glb")
    assert back.names == rig.names and len(back.faces) == len(rig.faces) and back.pictures.same(rig.pictures)
    moved = np.unique(back.faces[back.triangle_materials == Material.EYE])
    assert not back.deltas[:-1, moved].any()
    np.testing.assert_allclose(np.abs(back.deltas[-1, moved]).max(), 2 * np.abs(rig.deltas[-1]).max(), rtol=0.9)


@pytest.mark.parametrize("node", [{}, {"translation": [9, 0, 0]}])
def test_another_head_and_what_no_head_wears_are_left(full_rig, tmp_path, node):
    rig = haired(full_rig)
    document, binary = taken_into_meshes(tmp_path, rig, sourced=False)
    skin = document["meshes"][1]
    together = document["nodes"][-1]["children"]
    body = {"primitives": [{k: v for k, v in skin["primitives"][0].items() if k != "targets"}]}
    for other in (copy.deepcopy(skin), body):
        together.append(len(document["nodes"]))
        document["nodes"].append({"mesh": len(document["meshes"])} | node)
        document["meshes"].append(other)
    put_together(tmp_path / "b.glb", document, binary)
    assert len(read_gltf(tmp_path / "b.glb").faces) == len(rig.faces)


def test_pictures_have_names(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", changing(moody(haired(full_rig))))
    names = [image["name"] for image in taken_apart(tmp_path / "a.glb")[0]["images"]]
    assert names == ["skin", "eyes", "hair", "skin sad", "skin ü 微笑", "skin changes"]


def test_what_moves_nothing_is_stored_once(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    for primitive in gltf.meshes[0].primitives:
        places = [index for target in primitive.targets for index in target.values()]
        still = {index for index in places if not values(gltf, index).any()}
        assert len(still) == 1 and places.count(*still) >= 4


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("name", ["full_rig", "head_rig"])
def test_what_was_written_comes_back(name, sparse, request, tmp_path):
    rig = request.getfixturevalue(name)
    write_gltf(tmp_path / "a.glb", rig, sparse=sparse, animation=movement(rig))
    back = read_gltf(tmp_path / "a.glb")
    assert back.names == rig.names
    np.testing.assert_array_equal(back.neutral, rig.neutral)
    np.testing.assert_array_equal(back.deltas, rig.deltas)
    np.testing.assert_array_equal(back.faces, rig.faces)
    corners = rig.mesh.uv_faces
    np.testing.assert_allclose(back.mesh.uvs[back.mesh.uv_polygons], rig.mesh.uvs[corners], rtol=0, atol=1e-6)
    assert back.pictures.same(rig.pictures)
    if rig.materials is None:
        assert back.materials is None
    else:
        np.testing.assert_array_equal(back.materials, np.repeat(rig.materials, 2))


def test_a_head_that_keeps_still_comes_back(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", still(full_rig))
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    (mesh,) = gltf.meshes
    assert not mesh.weights and not mesh.extras and not any(p.targets for p in mesh.primitives)
    back = read_gltf(tmp_path / "a.glb")
    assert back.names == () and back.deltas.shape == (0, *full_rig.neutral.shape)
    np.testing.assert_array_equal(back.neutral, full_rig.neutral)
    np.testing.assert_array_equal(back.faces, full_rig.faces)
    np.testing.assert_array_equal(back.materials, np.repeat(full_rig.materials, 2))
    expected = full_rig.mesh.uvs[full_rig.mesh.uv_faces]
    np.testing.assert_allclose(back.mesh.uvs[back.mesh.uv_polygons], expected, atol=1e-6)
    assert back.pictures.same(full_rig.pictures)


def test_a_mesh_with_targets_goes_before_one_without(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    bare = [{k: v for k, v in p.items() if k != "targets"} for p in document["meshes"][0]["primitives"]]
    document["meshes"].insert(0, {"primitives": bare})
    put_together(tmp_path / "a.glb", document, binary)
    assert read_gltf(tmp_path / "a.glb").names == full_rig.names
    document["meshes"].pop()
    put_together(tmp_path / "a.glb", document, binary)
    assert read_gltf(tmp_path / "a.glb").names == ()


def test_vertices_of_no_triangle_come_back_in_their_place(full_rig, tmp_path):
    rig = replace(plain(full_rig), mesh=Mesh(full_rig.neutral, full_rig.faces[10:-20]))
    write_gltf(tmp_path / "a.glb", rig)
    back = read_gltf(tmp_path / "a.glb")
    assert len(np.unique(rig.faces)) < len(rig.neutral)
    for key in ("neutral", "deltas", "faces"):
        np.testing.assert_array_equal(getattr(back, key), getattr(rig, key))
    assert back.mesh.is_plain and back.materials is back.pictures.skin is None


def test_seams_split_vertices_and_show_no_edge(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    skin, eyes = gltf.meshes[0].primitives
    assert [gltf.materials[p.material].name for p in (skin, eyes)] == ["skin", "eyes"]
    half = len(full_rig.neutral) // 2
    # Each row of the bands has one vertex at its seam.
    for primitive, seen in ((skin, range(half)), (eyes, range(half, 2 * half))):
        source = sources(gltf, primitive)
        assert set(source) == set(seen) and len(source) == half + half // 8
        uvs = values(gltf, primitive.attributes.TEXCOORD_0)
        assert len(np.unique(np.c_[source, uvs], axis=0)) == len(source)
        shared = [values(gltf, primitive.attributes.NORMAL)] + [values(gltf, t["NORMAL"]) for t in primitive.targets]
        for array in shared:
            assert len(np.unique(np.c_[source, array], axis=0)) == half
    plain_skin = values(gltf, skin.attributes.NORMAL)
    outwards = values(gltf, skin.attributes.POSITION) * [1, 0, 1]
    assert ((plain_skin * outwards).sum(1) > 0.9 * np.linalg.norm(outwards, axis=1)).all()


def test_v_runs_from_the_top(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    skin = gltf.meshes[0].primitives[0]
    high = values(gltf, skin.attributes.POSITION)[:, 1].argmax()
    assert values(gltf, skin.attributes.TEXCOORD_0)[high, 1] == pytest.approx(0.25)
    assert full_rig.mesh.uvs[:, 1].max() == pytest.approx(0.75)


def test_normals_are_means_by_area_and_change_only_beside_what_moves(full_rig):
    triangles, neutral = full_rig.faces, full_rig.neutral.astype(float)

    def slow(vertices):
        total = np.zeros_like(vertices)
        for a, b, c in triangles:
            total[[a, b, c]] += np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        return total / np.linalg.norm(total, axis=1, keepdims=True)

    normals, added = shading_normals(full_rig)
    np.testing.assert_allclose(normals, slow(neutral), atol=1e-6)
    for delta, change in zip(full_rig.deltas, added, strict=True):
        np.testing.assert_allclose(normals + change, slow(neutral + delta), atol=1e-6)
        moved = set(np.flatnonzero(delta.any(1)).tolist())
        beside = {v for triangle in triangles.tolist() if moved & set(triangle) for v in triangle}
        assert set(np.flatnonzero(change.any(1)).tolist()) <= beside
    assert added[:2].any((1, 2)).all() and not added[2:].any()


def test_vertices_without_area_look_forward(full_rig):
    line = Mesh(np.float32([1, 0, 0]) * full_rig.neutral, full_rig.faces)
    flat = replace(plain(full_rig), mesh=line, deltas=0 * full_rig.deltas)
    normals, added = shading_normals(flat)
    np.testing.assert_array_equal(normals, np.tile([0, 0, 1], (len(normals), 1)))
    assert not added.any()


def test_sparse_stores_only_what_moves(full_rig, head_rig, tmp_path):
    for name, sparse in (("dense", False), ("sparse", True)):
        write_gltf(tmp_path / f"{name}.glb", head_rig, sparse=sparse)
    assert (tmp_path / "sparse.glb").stat().st_size < 0.5 * (tmp_path / "dense.glb").stat().st_size
    write_gltf(tmp_path / "a.glb", full_rig, sparse=True)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    skin, eyes = gltf.meshes[0].primitives
    # The lowest row, with the vertex at its seam twice; its ring is two rows.
    assert gltf.accessors[skin.targets[0]["POSITION"]].sparse.count == 9
    assert gltf.accessors[skin.targets[0]["NORMAL"]].sparse.count <= 18
    for target in (eyes.targets[0], skin.targets[2], skin.targets[3]):
        for index in target.values():
            assert gltf.accessors[index].sparse is gltf.accessors[index].bufferView is None


@pytest.mark.parametrize(("side", "code"), [(255, 5123), (256, 5125)])
def test_indices_are_as_wide_as_they_must(side, code, tmp_path):
    write_gltf(tmp_path / "a.glb", grid(side), sparse=True)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    assert gltf.accessors[gltf.meshes[0].primitives[0].indices].componentType == code
    np.testing.assert_array_equal(read_gltf(tmp_path / "a.glb").faces, grid(side).faces)


def test_an_animation_is_stored_as_it_is(full_rig, tmp_path):
    moving = movement(full_rig)
    write_gltf(tmp_path / "a.glb", full_rig, animation=moving)
    gltf = pygltflib.GLTF2.load(tmp_path / "a.glb")
    (animation,) = gltf.animations
    stored = {}
    for channel in animation.channels:
        sampler = animation.samplers[channel.sampler]
        assert channel.target.node == 0 and sampler.interpolation == "LINEAR"
        times = gltf.accessors[sampler.input]
        np.testing.assert_array_equal(values(gltf, sampler.input)[:, 0], np.float32(moving.times))
        np.testing.assert_array_equal(np.float32(times.min + times.max), np.float32(moving.times[[0, -1]]))
        stored[channel.target.path] = values(gltf, sampler.output)
    assert set(stored) == {"weights", "rotation"}
    np.testing.assert_allclose(stored["weights"].reshape(7, -1), moving.weights, atol=1e-6)
    np.testing.assert_allclose(stored["rotation"], moving.rotations, atol=1e-6)


def stood(folder, rig, turned, nodes, animation=None):
    """The rig as it comes back from a file in which it is ``turned`` (3,3), under nodes whose mesh is the first's."""
    mesh = rig.mesh.with_vertices((rig.neutral @ turned.T).astype(np.float32))
    write_gltf(folder / "a.glb", replace(rig, mesh=mesh, deltas=rig.deltas @ turned.T), animation=animation)
    document, binary = taken_apart(folder / "a.glb")
    document["nodes"] = [document["nodes"][0] | nodes[0], *nodes[1:]]
    document["scenes"][0]["nodes"] = [len(nodes) - 1]
    put_together(folder / "b.glb", document, binary)
    return read_gltf(folder / "b.glb")


LYING = {"rotation": [-(0.5**0.5), 0, 0, 0.5**0.5]}
"""A node whose mesh has +z up."""


@pytest.mark.parametrize(
    "nodes",
    [[LYING | {"scale": [0.01] * 3, "translation": [0, 9, 0]}],
     [{"scale": [0.1] * 3}, LYING | {"scale": [0.1] * 3, "children": [0]}],
     [{"matrix": [0.01, 0, 0, 0, 0, 0, -0.01, 0, 0, 0.01, 0, 0, 0, 0, 0, 1]}]],
)  # fmt: skip
def test_a_head_is_put_right_by_its_nodes(full_rig, tmp_path, nodes):
    """In centimetres, +z up; where it is says nothing."""
    up = 100 * np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], np.float32)
    back = stood(tmp_path, full_rig, up, nodes)
    np.testing.assert_allclose(back.neutral, full_rig.neutral, atol=1e-6)
    np.testing.assert_allclose(back.deltas, full_rig.deltas, atol=1e-6)
    np.testing.assert_array_equal(back.faces, full_rig.faces)
    np.testing.assert_allclose(read_gltf_mesh(tmp_path / "b.glb").vertices, full_rig.neutral, atol=1e-6)


def test_a_head_that_its_node_mirrors_is_not_inside_out(full_rig, tmp_path):
    back = stood(tmp_path, full_rig, np.eye(3, dtype=np.float32), [{"scale": [-1, 1, 1]}])
    np.testing.assert_array_equal(back.neutral, full_rig.neutral * [-1, 1, 1])
    np.testing.assert_array_equal(back.deltas, full_rig.deltas * np.float32([-1, 1, 1]))
    np.testing.assert_array_equal(back.faces, full_rig.faces[:, ::-1])
    corners = full_rig.mesh.uvs[full_rig.mesh.uv_faces][:, ::-1]
    np.testing.assert_allclose(back.mesh.uvs[back.mesh.uv_polygons], corners, atol=1e-6)


def test_what_an_animation_moves_is_not_how_a_head_stands(full_rig, tmp_path):
    """Such as the first turn of a head, which programs write to its node; the rest still counts."""
    moving = movement(full_rig)
    half = stood(tmp_path, full_rig, 2 * np.eye(3, dtype=np.float32), [LYING | {"scale": [0.5] * 3}], moving)
    np.testing.assert_array_equal(half.neutral, full_rig.neutral)
    np.testing.assert_array_equal(half.deltas, full_rig.deltas)


@pytest.mark.parametrize("node", [[0], -1, "head"])
def test_an_animation_of_what_is_no_node_is_refused(full_rig, tmp_path, node):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["animations"] = [{"channels": [{"target": {"node": node, "path": "rotation"}}]}]
    put_together(tmp_path / "a.glb", document, binary)
    with pytest.raises(InputError, match="node: expected a whole number"):
        read_gltf(tmp_path / "a.glb")


def test_names_of_targets_that_are_gone_are_no_expressions(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    for primitive in document["meshes"][0]["primitives"]:
        del primitive["targets"]
    put_together(tmp_path / "a.glb", document, binary)
    back = read_gltf(tmp_path / "a.glb")
    assert back.names == () and back.deltas.shape == (0, *full_rig.neutral.shape)
    np.testing.assert_array_equal(read_gltf_mesh(tmp_path / "a.glb").faces, full_rig.faces)


def test_the_same_rig_gives_the_same_bytes(full_rig, tmp_path):
    for name in ("a", "b"):
        write_gltf(tmp_path / f"{name}.glb", full_rig, animation=movement(full_rig))
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_an_animation_of_other_shapes_is_refused(full_rig, tmp_path):
    moving = Animation([0, 0.1, 0.2], np.zeros((3, 3)))
    with pytest.raises(OutputError, match="b.glb: expected weights of the rig's 4 expressions, found 3"):
        write_gltf(tmp_path / "b.glb", full_rig, animation=moving)
    assert not (tmp_path / "b.glb").exists()


def test_a_folder_that_is_not_there_is_refused(full_rig, tmp_path):
    with pytest.raises(OutputError, match="cannot be written"):
        write_gltf(tmp_path / "none" / "a.glb", full_rig)


def foreign():
    """A file as other programs write them: interleaved, vertices shared by two primitives, no names, a moved node."""
    generator = np.random.default_rng(8)
    rows = generator.normal(size=(6, 8)).astype("<f4")
    fractions = generator.integers(0, 256, (6, 4), np.uint8)
    moved = generator.normal(size=(6, 3)).astype("<f4")
    first, second = np.array([[0, 1, 2], [2, 1, 3]], "<u1"), np.array([[3, 4, 5]], "<u4")
    few, where = generator.normal(size=(2, 3)).astype("<f4"), np.array([1, 4], "<u2")
    parts, views = b"", []
    for array, extra in ((rows, {"byteStride": 32}), (fractions, {"byteStride": 4}), (moved, {}), (first, {}),
                         (second, {}), (few, {}), (where, {})):  # fmt: skip
        views.append({"buffer": 0, "byteOffset": len(parts), "byteLength": array.nbytes} | extra)
        parts += array.tobytes() + bytes(-array.nbytes % 4)
    sparse = {"count": 2, "indices": {"bufferView": 6, "componentType": 5123}, "values": {"bufferView": 5}}
    vector = {"componentType": 5126, "count": 6, "type": "VEC3"}
    accessors = [
        vector | {"bufferView": 0, "byteOffset": 8},
        {"componentType": 5121, "normalized": True, "count": 6, "type": "VEC2", "bufferView": 1},
        vector | {"bufferView": 2},
        vector | {"bufferView": 2, "sparse": sparse},
        {"componentType": 5121, "count": 6, "type": "SCALAR", "bufferView": 3},
        {"componentType": 5125, "count": 3, "type": "SCALAR", "bufferView": 4},
    ]
    vertices = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "targets": [{"POSITION": 2}, {"POSITION": 3}, {"NORMAL": 2}],
    }
    document = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 1, "scale": [2, 2, 2]}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}}]},
            {"primitives": [vertices | {"indices": 4}, vertices | {"indices": 5}]},
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(parts)}],
    }
    sparsely = moved.copy()
    sparsely[where] = few
    faces = np.concatenate([first, second])
    return document, parts, rows[:, 2:5], [moved, sparsely, 0 * moved], faces, fractions[:, :2] / 255


def test_other_programs_files_are_read(tmp_path):
    document, binary, neutral, deltas, faces, fractions = foreign()
    put_together(tmp_path / "a.glb", document, binary)
    rig = read_gltf(tmp_path / "a.glb")
    assert rig.names == ("target_0", "target_1", "target_2")
    np.testing.assert_array_equal(rig.neutral, neutral)
    np.testing.assert_array_equal(rig.deltas, deltas)
    np.testing.assert_array_equal(rig.faces, faces)
    uvs = np.stack([fractions[:, 0], 1 - fractions[:, 1]], axis=1)
    np.testing.assert_allclose(rig.mesh.uvs[rig.mesh.uv_polygons], uvs[faces], atol=1e-6)
    assert rig.materials is rig.pictures.skin is None


def test_the_picture_of_a_mesh_of_which_a_part_has_no_material_is_read(tmp_path):
    document, binary, *_ = foreign()
    picture = np.random.default_rng(9).integers(0, 256, (4, 4, 3), np.uint8)
    uri = "data:image/png;base64," + base64.b64encode(png_bytes(picture)).decode()
    document["meshes"][1]["primitives"][1]["material"] = 0
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    document |= {"textures": [{"source": 0}], "images": [{"uri": uri}]}
    put_together(tmp_path / "a.glb", document, binary)
    np.testing.assert_array_equal(read_gltf(tmp_path / "a.glb").pictures.skin, picture)


def moved(**changes):
    return {"extensions": {"KHR_texture_transform": changes}}


def placed(colour):
    """``foreign`` with a picture that lies as a baseColorTexture says, and a second set of UVs, the first one swapped;
    its binary, its triangles, and the first set."""
    document, binary, _, _, faces, fractions = foreign()
    swapped = np.ascontiguousarray(fractions[:, ::-1]).astype("<f4")
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": swapped.nbytes})
    document["accessors"].append({"componentType": 5126, "count": 6, "type": "VEC2", "bufferView": 7})
    document["buffers"][0]["byteLength"] += swapped.nbytes
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": colour}}]
    for primitive in document["meshes"][1]["primitives"]:
        primitive |= {"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 6}, "material": 0}
    return document | {"extensionsRequired": ["KHR_texture_transform"]}, binary + swapped.tobytes(), faces, fractions


@pytest.mark.parametrize(
    ("colour", "expected"),
    [
        ({}, lambda u, v: (u, v)),
        ({"texCoord": 1}, lambda u, v: (v, u)),
        (moved(offset=[0.5, 0.25]), lambda u, v: (u + 0.5, v + 0.25)),
        (moved(scale=[2, -1]), lambda u, v: (2 * u, -v)),
        # A quarter turn against the clock leads to the right what was below.
        (moved(rotation=np.pi / 2, scale=[2, 3]), lambda u, v: (3 * v, -2 * u)),
        (moved(texCoord=1), lambda u, v: (v, u)),
        ({"texCoord": 1} | moved(offset=[1, 0], scale=[1, 0.5]), lambda u, v: (v + 1, u / 2)),
        ({"texCoord": 1} | moved(texCoord=0), lambda u, v: (u, v)),
    ],
)
def test_uvs_are_those_that_the_picture_lies_by(colour, expected, tmp_path):
    document, binary, faces, fractions = placed(colour)
    put_together(tmp_path / "a.glb", document, binary)
    u, v = expected(*fractions.T)
    for mesh in (read_gltf(tmp_path / "a.glb").mesh, read_gltf_mesh(tmp_path / "a.glb")):
        np.testing.assert_allclose(mesh.uvs[mesh.uv_faces], np.stack([u, 1 - v], axis=1)[faces], atol=1e-6)


def test_parts_of_a_mesh_lie_by_uvs_of_their_own(tmp_path):
    document, binary, faces, fractions = placed({"texCoord": 1})
    del document["meshes"][1]["primitives"][1]["material"]
    put_together(tmp_path / "a.glb", document, binary)
    mesh = read_gltf(tmp_path / "a.glb").mesh
    expected = np.concatenate([fractions[faces[:2], ::-1], fractions[faces[2:]]])
    np.testing.assert_allclose(mesh.uvs[mesh.uv_faces], expected * [1, -1] + [0, 1], atol=1e-6)


def test_a_picture_that_lies_by_uvs_that_are_not_there_has_none(tmp_path):
    document, binary, *_ = placed({"texCoord": 2})
    put_together(tmp_path / "a.glb", document, binary)
    assert read_gltf(tmp_path / "a.glb").mesh.uvs is None


@pytest.mark.parametrize(
    ("colour", "words"),
    [
        ({"texCoord": -1}, "texCoord: expected a whole number from 0"),
        (moved(offset=[0.5]), "offset: expected"),
        (moved(scale=2), "scale: expected list"),
        (moved(rotation="left"), "rotation: expected"),
        ({"extensions": {"KHR_texture_transform": []}}, "KHR_texture_transform: expected dict"),
    ],
)
def test_transforms_that_lie_are_refused(colour, words, tmp_path):
    document, binary, *_ = placed(colour)
    put_together(tmp_path / "a.glb", document, binary)
    with pytest.raises(InputError, match=words):
        read_gltf(tmp_path / "a.glb")


def test_a_scene_of_which_a_part_has_no_uvs_has_none(tmp_path):
    document, binary, neutral, _, faces, _ = foreign()
    for primitive in document["meshes"][1]["primitives"]:
        primitive.pop("targets")
    document["nodes"].append({"mesh": 0})
    document["scenes"] = [{"nodes": [0, 1]}]
    put_together(tmp_path / "a.glb", document, binary)
    mesh = read_gltf_mesh(tmp_path / "a.glb")
    assert mesh.uvs is mesh.uv_polygons is None
    corners = np.concatenate([2 * neutral[faces], neutral.reshape(2, 3, 3)])
    np.testing.assert_allclose(mesh.vertices[mesh.faces], corners, rtol=1e-6)
    document["scenes"] = [{"nodes": [0]}]
    put_together(tmp_path / "b.glb", document, binary)
    assert read_gltf_mesh(tmp_path / "b.glb").uvs is not None


def test_pictures_are_repeated_and_smooth_near_and_far(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    for sampler in pygltflib.GLTF2.load(tmp_path / "a.glb").samplers:
        assert (sampler.magFilter, sampler.minFilter) == (pygltflib.LINEAR, pygltflib.LINEAR_MIPMAP_LINEAR)


def test_clips_tell_how_long_and_of_how_many_frames_they_are(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig, animation=movement(full_rig))
    ((name, seconds, frames),) = [vars(clip).values() for clip in read_clips(tmp_path / "a.glb")]
    assert (name, seconds, frames) == ("animation", pytest.approx(0.2), 7)
    document, binary = taken_apart(tmp_path / "a.glb")
    document["animations"] = [{"name": "still"}, document["animations"][0] | {"name": "moving"}]
    put_together(tmp_path / "b.glb", document, binary)
    clips = [tuple(vars(clip).values()) for clip in read_clips(tmp_path / "b.glb")]
    assert clips == [("still", 0.0, 0), ("moving", pytest.approx(0.2), 7)]


@pytest.mark.parametrize(
    "animations", [[{"name": 3}], ["walk"], [{}] * 10_001, [{"samplers": [7]}], [{"samplers": [{"input": [0]}]}]]
)
def test_clips_that_lie_are_refused(full_rig, tmp_path, animations):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    put_together(tmp_path / "b.glb", document | {"animations": animations}, binary)
    with pytest.raises(InputError, match="expected"):
        read_clips(tmp_path / "b.glb")


def test_primitives_without_indices_take_their_vertices_in_turn(tmp_path):
    document, binary, neutral, *_ = foreign()
    for primitive in document["meshes"][1]["primitives"]:
        primitive.pop("indices")
    put_together(tmp_path / "a.glb", document, binary)
    np.testing.assert_array_equal(read_gltf(tmp_path / "a.glb").faces, [[0, 1, 2], [3, 4, 5]] * 2)


def deep(depth):
    return [deep(depth - 1)] if depth else 0


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("extensionsRequired", ["KHR_draco_mesh_compression"], "KHR_draco_mesh_compression"),
        ("meshes", [], "expected a mesh, found none"),
        ("meshes", {}, "meshes: expected list"),
        ("meshes/1/primitives/0/mode", 5, "mode: expected triangles"),
        ("meshes/1/primitives/0/targets", [{"POSITION": 2}], "targets: expected as many in every primitive"),
        ("meshes/1/primitives/0/targets", [2, 2, 2], "targets: expected objects"),
        ("meshes/1/primitives/0/attributes", {}, "POSITION: expected the number of"),
        ("meshes/1/primitives/0/attributes/POSITION", 6, "POSITION: expected the number of one of 6 accessors"),
        ("meshes/1/primitives/0/attributes/POSITION", -1, "POSITION: expected the number of one of 6 accessors"),
        ("meshes/1/primitives/0/attributes/POSITION", True, "POSITION: expected the number of one of 6 accessors"),
        ("meshes/1/primitives/0/attributes/_SOURCE_VERTEX", 1, "accessor: expected the type SCALAR"),
        ("meshes/1/primitives/0/indices", 2, "accessor: expected the type SCALAR"),
        ("meshes/1/extras", {"targetNames": ["a", "b"]}, "targetNames: expected 3 names"),
        ("meshes/1/extras", {"targetNames": ["a", "b", "a"]}, "distinct names"),
        ("meshes/1/extras", {"targetNames": ["a", "b", 3]}, "targetNames: expected 3 names"),
        ("accessors/2/count", 7, "POSITION: expected 6 values, found 7"),
        ("accessors/0/count", 10**9, "count: expected a whole number from 1 to 1000000"),
        ("accessors/0/count", 2.5, "count: expected a whole number"),
        ("accessors/0/count", 0, "count: expected a whole number"),
        ("accessors/0/type", "VEC2", "expected the type VEC3, found VEC2"),
        ("accessors/0/componentType", 5124, "componentType: expected one of"),
        ("accessors/0/componentType", 5123, "POSITION: expected floats"),
        ("accessors/0/componentType", [5126], "componentType: expected a whole number"),
        ("accessors/0/byteOffset", 40, "bufferView: expected at least 212 bytes, found 192"),
        ("accessors/0/byteOffset", -4, "byteOffset: expected a whole number"),
        ("accessors/0/bufferView", 99, "bufferView: expected the number of"),
        ("accessors/3/sparse/count", 7, "count: expected a whole number from 1 to 6"),
        ("accessors/3/sparse/indices/componentType", 5126, "bufferView: expected at least 8 bytes"),
        ("accessors/3/sparse/indices/bufferView", 2, "sparse: expected indices below 6"),
        ("accessors/3/sparse/values", None, "values: expected dict"),
        ("accessors/4/count", 5, "indices: expected three whole numbers"),
        ("accessors/5/bufferView", 2, "indices: expected three whole numbers below 6"),
        ("bufferViews/0/byteStride", 8, "byteStride: expected a whole number from 12"),
        ("bufferViews/0/byteLength", 10**6, "byteLength: expected a whole number"),
        ("bufferViews/0/buffer", 1, "buffer: expected the number of one of 1 buffers"),
        ("buffers/0/uri", "../secret.bin", "buffers: expected one inside the file"),
        ("extras", deep(100), "nested at most"),
    ],
)
def test_documents_that_lie_are_refused(place, value, words, tmp_path):
    document, binary, *_ = foreign()
    *parents, key = (int(part) if part.isdigit() else part for part in place.split("/"))
    holder = document
    for parent in parents:
        holder = holder[parent]
    holder[key] = value
    put_together(tmp_path / "a.glb", document, binary)
    with pytest.raises(InputError) as refused:
        read_gltf(tmp_path / "a.glb")
    assert words in str(refused.value) and "a.glb: " in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: b"", "empty file"),
        (lambda d: b"glTF", "truncated"),
        (lambda d: b"\x80\x04" + d, "found a pickle"),
        (lambda d: d[:-4], "expected a GLB file of"),
        (lambda d: d + b"more", "expected a GLB file of"),
        (lambda d: d[:4] + b"\1" + d[5:], "expected glTF 2, found version 1"),
        (lambda d: d[:12] + b"\xff\xff\xff\x7f" + d[16:], "expected a chunk of 2147483647 bytes"),
        (lambda d: d[:16] + b"BIN\0" + d[20:], "JSON first"),
        (lambda d: d[:20] + b"[" + d[21:], "expected strict JSON"),
    ],
)
def test_what_is_no_glb_is_refused(change, words, tmp_path):
    document, binary, *_ = foreign()
    put_together(tmp_path / "a.glb", document, binary)
    (tmp_path / "b.glb").write_bytes(change((tmp_path / "a.glb").read_bytes()))
    with pytest.raises(InputError) as refused:
        read_gltf(tmp_path / "b.glb")
    assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(("count", "targets"), [(10**6, 1000), (3, 1025)])
def test_a_small_file_cannot_ask_for_much_memory(count, targets, tmp_path):
    document, binary, *_ = foreign()
    document["accessors"] = [{"componentType": 5126, "count": count, "type": "VEC3"}]
    primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * targets}
    document["meshes"] = [{"primitives": [primitive]}]
    put_together(tmp_path / "a.glb", document, binary)
    with pytest.raises(InputError, match="at most"):
        read_gltf(tmp_path / "a.glb")


def test_many_primitives_cannot_ask_for_much_memory(tmp_path):
    document, binary, *_ = foreign()
    document["accessors"] += [{"componentType": 5125, "count": 3 * 10**6, "type": "SCALAR"}]
    document["meshes"][1]["primitives"] = [document["meshes"][1]["primitives"][0] | {"indices": 6}] * 1000
    put_together(tmp_path / "a.glb", document, binary)
    with pytest.raises(InputError, match="triangles, found more"):
        read_gltf(tmp_path / "a.glb")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s + np.float32(0.5), "_SOURCE_VERTEX: expected whole numbers"),
        (lambda s: s - np.float32(1), "_SOURCE_VERTEX: expected whole numbers"),
        (lambda s: s * np.float32(np.nan), "accessor: expected finite numbers"),
        (lambda s: s * np.float32(0), "_SOURCE_VERTEX: expected one place"),
    ],
)
def test_source_vertices_that_lie_are_refused(full_rig, change, words, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["_SOURCE_VERTEX"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
    changed = change(np.frombuffer(binary, "<f4", accessor["count"], start)).tobytes()
    put_together(tmp_path / "b.glb", document, binary[:start] + changed + binary[start + len(changed) :])
    with pytest.raises(InputError, match=words):
        read_gltf(tmp_path / "b.glb")


def test_a_picture_that_cannot_be_read_is_left_out(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, binary = taken_apart(tmp_path / "a.glb")
    at = binary.index(b"\x89PNG")
    put_together(tmp_path / "b.glb", document, binary[:at] + b"rubbish" + binary[at + 7 :])
    back = read_gltf(tmp_path / "b.glb")
    assert back.pictures.skin is None
    np.testing.assert_array_equal(back.pictures.eyes, full_rig.pictures.eyes)


def test_a_picture_in_a_text_is_read(full_rig, tmp_path):
    write_gltf(tmp_path / "a.gltf", full_rig)
    document = json.loads((tmp_path / "a.gltf").read_text())
    content = base64.b64encode(png_bytes(full_rig.pictures.skin)).decode()
    document["images"][0] = {"uri": f"data:image/png;base64,{content}"}
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    np.testing.assert_array_equal(read_gltf(tmp_path / "a.gltf").pictures.skin, full_rig.pictures.skin)
    document["images"][0]["uri"] = "skin.png"
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    assert read_gltf(tmp_path / "a.gltf").pictures.skin is None


def test_a_picture_as_webp_is_read(full_rig, tmp_path):
    write_gltf(tmp_path / "a.gltf", full_rig)
    document = json.loads((tmp_path / "a.gltf").read_text())
    stream = io.BytesIO()
    Image.fromarray(full_rig.pictures.skin).save(stream, "WEBP", lossless=True)
    document["images"].append({"uri": "data:image/webp;base64," + base64.b64encode(stream.getvalue()).decode()})
    document["textures"][0] = {"extensions": {"EXT_texture_webp": {"source": len(document["images"]) - 1}}}
    (tmp_path / "a.gltf").write_text(json.dumps(document | {"extensionsRequired": ["EXT_texture_webp"]}))
    np.testing.assert_array_equal(read_gltf(tmp_path / "a.gltf").pictures.skin, full_rig.pictures.skin)


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        ({}, (100, 50, 20)),
        ({"alphaMode": "OPAQUE"}, (100, 50, 20)),
        ({"alphaMode": "MASK"}, (255, 255, 255)),
        ({"alphaMode": "BLEND"}, (255, 255, 255)),
    ],
)
def test_alpha_of_an_opaque_material_says_nothing(mode, expected, tmp_path):
    document, binary, *_ = foreign()
    clear = np.full((4, 4, 4), (100, 50, 20, 0), np.uint8)
    uri = "data:image/png;base64," + base64.b64encode(png_bytes(clear)).decode()
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}} | mode]
    document["meshes"][1]["primitives"][0]["material"] = 0
    put_together(tmp_path / "a.glb", document | {"textures": [{"source": 0}], "images": [{"uri": uri}]}, binary)
    assert (read_gltf(tmp_path / "a.glb").pictures.skin == expected).all()


def test_moods_are_variants_of_the_skins_material_and_come_back(full_rig, tmp_path):
    rig = moody(haired(full_rig))
    write_gltf(tmp_path / "a.glb", rig)
    document, _ = taken_apart(tmp_path / "a.glb")
    used = ["KHR_materials_variants", "KHR_materials_anisotropy"]
    assert document["extensionsUsed"] == used and "extensionsRequired" not in document
    variants = document["extensions"]["KHR_materials_variants"]["variants"]
    assert [variant["name"] for variant in variants] == ["sad", "ü 微笑"]
    skins = [p for p in document["meshes"][0]["primitives"] if "extensions" in p]
    assert len(skins) == 1 and document["materials"][skins[0]["material"]]["name"] == "skin"
    mappings = skins[0]["extensions"]["KHR_materials_variants"]["mappings"]
    named = [document["materials"][mapping["material"]]["name"] for mapping in mappings]
    assert named == ["skin sad", "skin ü 微笑"] and [mapping["variants"] for mapping in mappings] == [[0], [1]]
    back = read_gltf(tmp_path / "a.glb")
    assert back.pictures.same(rig.pictures)
    for mood, expected in zip(back.moods, rig.moods, strict=True):
        assert mood.name == expected.name
        np.testing.assert_array_equal(mood.skin, expected.skin)


def test_changes_are_a_texture_that_the_skins_material_tells_of_and_come_back(full_rig, tmp_path):
    rig = changing(moody(full_rig))
    write_gltf(tmp_path / "a.glb", rig)
    document, _ = taken_apart(tmp_path / "a.glb")
    told = [material.get("extras", {}).get("textureChanges") for material in document["materials"]]
    assert told[0].pop("texture") == len(document["textures"]) - 1 and not any(told[1:])
    assert told[0] == {"columns": 4, "side": 4, "window": [0.1, 0.25, 0.75, 0.9], "gain": 0.5, "offset": 0.25}
    back = read_gltf(tmp_path / "a.glb").changes
    np.testing.assert_array_equal(back.picture, rig.changes.picture)
    np.testing.assert_array_equal(back.layout, rig.changes.layout)


@pytest.mark.parametrize(
    ("key", "value", "left"),
    [
        ("texture", 99, None),
        ("texture", "a", None),
        ("columns", 9, "rows of tiles"),
        ("columns", None, "as numbers"),
        ("window", [0, 0, 2, 1], "a window inside"),
        ("window", [0, 1], "eight numbers"),
        ("window", 3, "expected list"),
        ("gain", "a", "as numbers"),
        ("offset", 1e300, "as numbers"),
        ("side", 8, None),
    ],
)
def test_changes_that_do_not_fit(full_rig, tmp_path, key, value, left):
    write_gltf(tmp_path / "a.glb", changing(full_rig))
    document, binary = taken_apart(tmp_path / "a.glb")
    document["materials"][0]["extras"]["textureChanges"][key] = value
    if key == "side":
        document["materials"][0]["extras"]["textureChanges"]["columns"] = 2
    put_together(tmp_path / "a.glb", document, binary)
    if left is None:
        assert read_gltf(tmp_path / "a.glb").changes is None
    else:
        with pytest.raises(InputError, match=left):
            read_gltf(tmp_path / "a.glb")


def test_without_moods_nothing_is_said_of_variants(full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", full_rig)
    document, _ = taken_apart(tmp_path / "a.glb")
    assert "extensions" not in document and read_gltf(tmp_path / "a.glb").moods == ()


@pytest.mark.parametrize(
    ("change", "left"),
    [
        (lambda variants, mappings: variants[0].pop("name"), ["ü 微笑"]),
        (lambda variants, mappings: variants[0].update(name="ü 微笑"), ["ü 微笑"]),
        (lambda variants, mappings: mappings.pop(), ["sad"]),
        (lambda variants, mappings: mappings[0].update(variants=[0, 1]), ["sad", "ü 微笑"]),
        (lambda variants, mappings: mappings[1].update(variants=[7, -1, "x", 1]), ["sad", "ü 微笑"]),
        (lambda variants, mappings: mappings[1].update(variants=7), "expected list"),
        (lambda variants, mappings: mappings[1].update(material=99), "expected the number of one of"),
        (lambda variants, mappings: mappings.append(3), "expected the number of one of"),
        (lambda variants, mappings: mappings.extend(99 * mappings), "at most 64 variants"),
    ],
)
def test_variants_of_other_programs(change, left, full_rig, tmp_path):
    write_gltf(tmp_path / "a.glb", moody(full_rig))
    document, binary = taken_apart(tmp_path / "a.glb")
    (skin,) = [p for p in document["meshes"][0]["primitives"] if "extensions" in p]
    mappings = skin["extensions"]["KHR_materials_variants"]["mappings"]
    change(document["extensions"]["KHR_materials_variants"]["variants"], mappings)
    put_together(tmp_path / "b.glb", document, binary)
    if isinstance(left, str):
        with pytest.raises(InputError, match=left):
            read_gltf(tmp_path / "b.glb")
    else:
        assert [mood.name for mood in read_gltf(tmp_path / "b.glb").moods] == left


def leaves(value, path=()):
    """The places of everything in a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*path, key)
        yield from leaves(inner, (*path, key))


ODD = (None, True, -1, 0, 1, 5, 7, 255, 2**31, 2**64, 1.5, "", "VEC4", "\n", [], [0], {}, {"count": 1}, [[]], [{}])


@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_any_change_of_a_document_is_read_or_refused(tmp_path_factory, data):
    document, binary, *_ = foreign()
    document = copy.deepcopy(document)
    path = tmp_path_factory.getbasetemp() / "changed.glb"
    for _ in range(data.draw(st.integers(1, 3))):
        *parents, key = data.draw(st.sampled_from(list(leaves(document))))
        holder = document
        for parent in parents:
            holder = holder[parent]
        holder[key] = copy.deepcopy(data.draw(st.sampled_from(ODD)))
    put_together(path, document, binary)
    try:
        read_gltf(path)
    except InputError as error:
        assert "\n" not in str(error) and str(error).startswith(str(path))


def test_teeth_beside_a_grey_skin_are_grey(full_rig, tmp_path):
    kinds = np.where(full_rig.materials == Material.EYE, Material.GUMS, full_rig.materials)
    grey = Pictures(np.full((4, 4, 3), 120, np.uint8))
    write_gltf(tmp_path / "a.gltf", replace(full_rig, materials=kinds, pictures=grey))
    document = json.loads((tmp_path / "a.gltf").read_text())
    gums = next(each for each in document["materials"] if each["name"] == "gums")
    red, green, blue, _ = gums["pbrMetallicRoughness"]["baseColorFactor"]
    assert red == green == blue > 0
