"""Every format of meshes: what comes back, and what is refused before it costs anything."""

import base64
import json
import os
import pickle
import struct
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from caricli.errors import InputError, OutputError
from caricli.io.face import read_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.meshes import stl
from caricli.io.meshes.mesh import ANY_MESH, MESH_SUFFIXES, mesh_files, read_mesh, write_mesh
from caricli.io.meshes.obj import read_obj
from caricli.limits import MAX_FILE_BYTES
from caricli.structures import Mesh

OTHERS = tuple(suffix for suffix in MESH_SUFFIXES if suffix != ".obj")
SHARED = tuple(suffix for suffix in MESH_SUFFIXES if suffix != ".stl")
"""Formats whose triangles share their vertices."""
SINGLE = 1e-6
"""How far a coordinate of about 1 may come back from where it was: what every format holds."""


@pytest.fixture(scope="session")
def ball_mesh(ball):
    vertices, faces = ball
    return Mesh(vertices.astype(np.float32), faces)


def quads():
    """Two quads with a seam between them in the picture."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(3.0), np.arange(2.0)))
    polygons = np.array([[0, 1, 4, 3], [1, 2, 5, 4]], np.int32)
    uvs = np.array([[0, 0], [0.4, 0], [0.4, 1], [0, 1], [0.6, 0], [1, 0], [1, 1], [0.6, 1]])
    return Mesh(np.stack([x, y, 0.25 * x], axis=1), polygons, uvs, np.arange(8).reshape(2, 4))


def refused(path, *words, reader=read_mesh):
    with pytest.raises(InputError) as caught:
        reader(path)
    said = str(caught.value)
    assert said.startswith(str(path)) and said.count("\n") == 0 and len(said) < 600, said
    assert all(word in said for word in words), said
    return said


def test_the_formats_that_are_promised():
    assert MESH_SUFFIXES[:5] == (".obj", ".ply", ".stl", ".glb", ".gltf")
    assert ANY_MESH.startswith("a mesh (.obj, .ply, ") and all(suffix in ANY_MESH for suffix in MESH_SUFFIXES)


@pytest.mark.parametrize("suffix", SHARED)
def test_vertices_faces_and_order_come_back(ball_mesh, tmp_path, suffix):
    write_mesh(tmp_path / f"a{suffix}", ball_mesh)
    back = read_mesh(tmp_path / f"a{suffix}")
    assert back.vertices.dtype == np.float64
    np.testing.assert_allclose(back.vertices, ball_mesh.vertices, rtol=0, atol=SINGLE)
    np.testing.assert_array_equal(back.faces, ball_mesh.faces)
    assert back.topology_id == ball_mesh.topology_id


@pytest.mark.parametrize("suffix", SHARED)
def test_a_head_keeps_its_order_too(head_template, tmp_path, suffix):
    write_mesh(tmp_path / f"a{suffix}", head_template)
    back = read_mesh(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(back.vertices, head_template.vertices, rtol=0, atol=1e-7)
    np.testing.assert_array_equal(back.faces, head_template.faces)


@pytest.mark.parametrize("suffix", [*map(str.upper, MESH_SUFFIXES), ".Obj", ".glTF"])
def test_capitals_in_the_suffix(ball_mesh, tmp_path, suffix):
    write_mesh(tmp_path / f"a{suffix}", ball_mesh)
    assert len(read_mesh(tmp_path / f"a{suffix}").faces) == len(ball_mesh.faces)


def test_stl_comes_back_up_to_the_order_of_vertices(ball_mesh, tmp_path):
    write_mesh(tmp_path / "a.stl", ball_mesh)
    back = read_mesh(tmp_path / "a.stl")
    assert back.vertices.shape == ball_mesh.vertices.shape
    np.testing.assert_array_equal(back.vertices[back.faces], ball_mesh.vertices[ball_mesh.faces])
    first = ball_mesh.faces.ravel()[np.sort(np.unique(ball_mesh.faces, return_index=True)[1])]
    np.testing.assert_array_equal(back.vertices, ball_mesh.vertices[first])


def test_text_forms(ball_mesh, tmp_path):
    triangles = trimesh.Trimesh(ball_mesh.vertices, ball_mesh.faces, process=False)
    (tmp_path / "a.stl").write_text(trimesh.exchange.stl.export_stl_ascii(triangles))
    (tmp_path / "a.ply").write_bytes(trimesh.exchange.ply.export_ply(triangles, encoding="ascii"))
    back = read_mesh(tmp_path / "a.stl")
    np.testing.assert_allclose(back.vertices[back.faces], ball_mesh.vertices[ball_mesh.faces], atol=1e-7)
    back = read_mesh(tmp_path / "a.ply")
    np.testing.assert_allclose(back.vertices, ball_mesh.vertices, atol=1e-7)
    np.testing.assert_array_equal(back.faces, ball_mesh.faces)


def test_two_solids_of_a_text_stl_are_one_mesh(tmp_path):
    facet = "facet normal 0 0 1\nouter loop\n{}\nendloop\nendfacet\n"
    corners = [["vertex 0 0 0", "vertex 1 0 0", "vertex 0 1 0"], ["vertex 1 0 -0.0", "vertex 1 1 0", "vertex 0 1 0"]]
    solids = [f"solid s\n{facet.format(chr(10).join(rows))}endsolid s\n" for rows in corners]
    (tmp_path / "a.stl").write_text("".join(solids))
    mesh = read_mesh(tmp_path / "a.stl")
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 3, 2]] and len(mesh.vertices) == 4


def test_quads_of_a_ply_stay_quads(tmp_path):
    mesh = quads()
    rows = [" ".join(map(str, vertex)) for vertex in mesh.vertices.tolist()]
    rows += ["4 " + " ".join(map(str, polygon)) for polygon in mesh.polygons.tolist()]
    header = (
        "ply\nformat ascii 1.0\ncomment a\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
    )
    header += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "a.ply").write_text(header + "\n".join(rows) + "\n")
    back = read_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.polygons, mesh.polygons)
    np.testing.assert_array_equal(back.vertices, mesh.vertices)


def test_polygons_become_the_same_triangles_everywhere(tmp_path):
    for suffix in SHARED:
        write_mesh(tmp_path / f"a{suffix}", quads())
        assert read_mesh(tmp_path / f"a{suffix}").topology_id == quads().topology_id


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_seams_keep_vertices_together_and_the_picture_is_embedded(tmp_path, suffix):
    picture = np.random.default_rng(0).integers(0, 256, (8, 8, 3), np.uint8)
    write_png(tmp_path / "skin.png", picture)
    write_mesh(tmp_path / f"a{suffix}", quads(), texture="skin.png")
    back = read_mesh(tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(back.vertices, quads().vertices)
    np.testing.assert_allclose(back.uvs[back.uv_faces], quads().uvs[quads().uv_faces], atol=1e-6)
    scene = trimesh.load_scene(tmp_path / f"a{suffix}")
    (part,) = scene.geometry.values()
    np.testing.assert_array_equal(np.asarray(part.visual.material.baseColorTexture), picture)


def test_an_obj_names_its_picture(tmp_path):
    write_mesh(tmp_path / "a.obj", quads(), "skin.png", tmp_path / "b.mtl")
    assert "map_Kd skin.png" in (tmp_path / "b.mtl").read_text()
    assert read_obj(tmp_path / "a.obj").polygons.tolist() == quads().polygons.tolist()


def test_what_cannot_be_written_is_refused(tmp_path):
    for name, words in (
        ("a.none", f"expected {ANY_MESH}, found '.none'"),
        ("a", "found ''"),
    ):
        with pytest.raises(OutputError) as caught:
            write_mesh(tmp_path / name, quads())
        assert words in str(caught.value)
    for name in ("a.ply", "a.stl"):
        with pytest.raises(OutputError, match="expected .obj, .glb or .gltf for a mesh with a texture"):
            write_mesh(tmp_path / name, quads(), texture="skin.png")
    with pytest.raises(OutputError, match="UVs for the texture"):
        write_mesh(tmp_path / "a.glb", Mesh(quads().vertices, quads().polygons), texture="skin.png")
    for suffix in MESH_SUFFIXES:
        with pytest.raises(OutputError, match="cannot be written"):
            write_mesh(tmp_path / "none" / f"a{suffix}", quads())
    assert not any(tmp_path.iterdir())


def test_another_suffix_is_refused(tmp_path):
    refused(tmp_path / "a.none", f"expected {ANY_MESH}, found '.none'")


@pytest.mark.parametrize("suffix", OTHERS)
def test_a_face_can_be_any_mesh(ball_mesh, tmp_path, suffix):
    write_mesh(tmp_path / f"a{suffix}", ball_mesh)
    face = read_face(tmp_path / f"a{suffix}")
    assert face.latent is face.camera is None and face.vertices.dtype == np.float64
    corners = ball_mesh.vertices[ball_mesh.faces]
    np.testing.assert_allclose(face.vertices[face.faces], corners, rtol=0, atol=SINGLE)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_of_a_rig_it_is_the_neutral_mesh(full_rig, tmp_path, suffix):
    write_gltf(tmp_path / f"a{suffix}", full_rig, sparse=True)
    mesh = read_mesh(tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(mesh.vertices, full_rig.neutral)
    np.testing.assert_array_equal(mesh.faces, full_rig.faces)


def test_another_programs_rig_is_as_large_as_its_node_and_stays_at_the_origin(tmp_path):
    document, binary = scene_document([{"mesh": 0, "scale": [2, 2, 2], "translation": [5, 0, 0]}])
    document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    put_together(tmp_path / "a.glb", document, binary)
    assert read_mesh(tmp_path / "a.glb").vertices.tolist() == [[0, 0, 0], [2, 0, 0], [0, 4, 0]]


def put_together(path, document, binary):
    """A GLB of a document and its binary chunk."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def scene_document(nodes, roots=(0,)):
    """A triangle, shown by nodes."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], "<f4")
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(roots)}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3", "bufferView": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
    }, corners.tobytes()


def test_a_scene_is_read_where_its_nodes_put_it(tmp_path):
    half = float(np.sqrt(0.5))
    nodes = [
        {"children": [1, 2, 3, 4], "translation": [0, 0, 5]},
        {"mesh": 0, "scale": [2, 2, 2]},
        {"mesh": 0, "rotation": [half, 0, 0, half]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1]},
        {"mesh": 0, "skin": 0, "translation": [9, 9, 9]},
    ]
    put_together(tmp_path / "a.glb", *scene_document(nodes))
    mesh = read_mesh(tmp_path / "a.glb")
    expected = [
        [[0, 0, 5], [2, 0, 5], [0, 4, 5]],
        [[0, 0, 5], [1, 0, 5], [0, 0, 7]],
        [[7, 0, 5], [6, 0, 5], [7, 2, 5]],
        [[0, 0, 0], [1, 0, 0], [0, 2, 0]],
    ]
    np.testing.assert_allclose(mesh.vertices.reshape(4, 3, 3), expected, atol=1e-6)
    # A mirror turns triangles inside out.
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5], [8, 7, 6], [9, 10, 11]]
    theirs = trimesh.load_scene(tmp_path / "a.glb").to_mesh()
    order = np.lexsort(theirs.vertices.T)
    skinned = len(mesh.vertices) - 3
    ours = np.concatenate([mesh.vertices[:skinned], mesh.vertices[skinned:] + [9, 9, 14]])
    np.testing.assert_allclose(theirs.vertices[order], ours[np.lexsort(ours.T)], atol=1e-5)


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        ([{"mesh": 0, "children": [0]}], "nodes: expected a tree"),
        ([{"children": [1, 1]}, {"mesh": 0}], "nodes: expected a tree"),
        ([{"children": [7]}], "expected the number of one of 1 nodes"),
        ([{"children": [True]}], "expected the number of one of 1 nodes"),
        ([{}], "expected a mesh in the scene, found none"),
        ([{"mesh": 1}], "expected the number of one of 1 meshes"),
        ([{"mesh": 0, "scale": [1, 2]}], "scale: expected"),
        ([{"mesh": 0, "scale": [1, 2, "3"]}], "scale: expected"),
        ([{"mesh": 0, "rotation": [0, 0, 0, 0]}], "rotation: expected a unit quaternion"),
        ([{"mesh": 0, "matrix": [1e10] * 16}], "matrix: expected"),
        ([{"mesh": 0, "matrix": [1e8] * 16}], "vertices: expected finite coordinates"),
        ([{"mesh": 0, "translation": 3}], "translation: expected list"),
    ],
)
def test_scenes_that_lie_are_refused(tmp_path, nodes, words):
    put_together(tmp_path / "a.glb", *scene_document(nodes))
    refused(tmp_path / "a.glb", words)


@pytest.mark.filterwarnings("error")
def test_transforms_without_end_are_refused(tmp_path):
    nodes = [{"children": [k + 1], "scale": [1e9] * 3} for k in range(40)] + [{"mesh": 0}]
    put_together(tmp_path / "a.glb", *scene_document(nodes))
    refused(tmp_path / "a.glb", "vertices: expected finite coordinates")


def test_many_nodes_cannot_ask_for_much_memory(tmp_path):
    nodes = [{"mesh": 0} for _ in range(40_000)]
    put_together(tmp_path / "a.glb", *scene_document(nodes, range(len(nodes))))
    refused(tmp_path / "a.glb", "at most 16384 nodes")
    document, _ = scene_document([{"mesh": 0} for _ in range(9)], range(9))
    document["accessors"][0] |= {"count": 200_000}
    document["bufferViews"][0] |= {"byteLength": 2_400_000}
    put_together(tmp_path / "b.glb", document, bytes(2_400_000))
    document["accessors"][0]["count"] = 199_998
    put_together(tmp_path / "b.glb", document, bytes(2_400_000))
    refused(tmp_path / "b.glb", "at most 1000000 vertices and")


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.parametrize("key", ["buffers", "images"])
@pytest.mark.parametrize(
    "uri", ["mesh.bin", "../mesh.bin", "/etc/passwd", "file:///etc/passwd", "https://example.org/a", "%2e%2e/a", 3, ""]
)
def test_other_files_are_never_opened(tmp_path, monkeypatch, suffix, key, uri):
    (tmp_path / "mesh.bin").write_bytes(bytes(36))
    document, binary = scene_document([{"mesh": 0}])
    if suffix == ".gltf":
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    document.setdefault(key, [{}])[0]["uri"] = uri
    path = tmp_path / f"a{suffix}"
    if suffix == ".glb":
        put_together(path, document, binary)
    else:
        path.write_text(json.dumps(document))
    opened = []
    sys_open = open

    def watching(name, *args, **kwargs):
        opened.append(str(name))
        return sys_open(name, *args, **kwargs)

    monkeypatch.setattr("builtins.open", watching)
    refused(path, f"{key}: expected one inside the file, found another file")
    assert opened == [str(path)]


def test_data_that_is_inside_a_gltf_is_read(tmp_path):
    document, binary = scene_document([{"mesh": 0}])
    document["buffers"][0]["uri"] = "data:application/gltf-buffer;base64," + base64.b64encode(binary).decode()
    (tmp_path / "a.gltf").write_text("\ufeff" + json.dumps(document), "utf-8")
    assert read_mesh(tmp_path / "a.gltf").vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 2, 0]]
    document["buffers"].append(dict(document["buffers"][0]))
    document["bufferViews"][0]["buffer"] = 1
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    assert len(read_mesh(tmp_path / "a.gltf").vertices) == 3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,!!"}]}, "expected base64"),
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,AAAA"}]}, "byteLength: expected a whole number"),
        ({"buffers": [{"byteLength": 36}]}, "found another file"),
        ({"buffers": [3]}, "buffers: expected a list of objects"),
        ({"buffers": {}}, "buffers: expected a list of objects"),
        ({"meshes": []}, "expected a mesh, found none"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
    ],
)
def test_gltf_texts_that_lie_are_refused(tmp_path, change, words):
    document, binary = scene_document([{"mesh": 0}])
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    (tmp_path / "a.gltf").write_text(json.dumps(document | change))
    refused(tmp_path / "a.gltf", words)


HEADER = (
    b"ply\nformat %s 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face %d\nproperty list uchar int vertex_indices\nend_header\n"
)


@pytest.mark.parametrize("form", [b"ascii", b"binary_little_endian", b"binary_big_endian"])
def test_a_ply_cannot_claim_much(tmp_path, form):
    path = tmp_path / "a.ply"
    for vertices, faces, words in ((10**9, 1, "of vertex, found 1000000000"), (3, 10**9, "of face, found 1000000000")):
        path.write_bytes(HEADER % (form, vertices, faces) + bytes(100))
        assert words in refused(path)
    path.write_bytes(HEADER % (form, 10**6, 1) + bytes(100))
    refused(path, "expected")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"ply\n" + b"comment\n" * 10**5, "with a header of at most"),
        (b"ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "expected 'element NAME COUNT'"),
        (b"ply\nformat ascii 1.0\nelement vertex\nend_header\n", "expected 'element NAME COUNT'"),
        (b"ply\nformat ascii 1.0\nelement vertex 1_0\nend_header\n", "expected 'element NAME COUNT'"),
        (b"ply\nformat ascii 1.0\nelement edge 3\nend_header\n", "found edges"),
        (b"ply\nformat ascii 1.0\n\x1celement vertex 1000000000\nend_header\n", "expected a line of a PLY header"),
        (b"ply\nformat ascii 1.0\nanelement vertex 1000000000\nend_header\n", "expected a line of a PLY header"),
        (b"ply\nformat ascii 1.0\n\nend_header\n", "expected a line of a PLY header"),
        (
            b"ply\nformat ascii 1.0\ncomment end_header?\nelement vertex 1000000000\nend_header\n",
            "of vertex, found 1000",
        ),
        (b"ply\ncomment a\nformat ascii 1.0\nend_header\n", "in line 2"),
        (b"ply\nformat latin 1.0\nend_header\n", "in line 2"),
        (b"ply\nend_header\n", "in line 2"),
        (b"ply\nformat ascii 1.0\nelement a 2000000\nelement b 2000000\nend_header\n", "at most 3000000 rows"),
        (b"ply\nformat ascii 1.0\n" + b"property float x\n" * 300 + b"end_header\n", "at most 256 properties"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" + b"\n" * 10**6, "expected 4 lines of values"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n", "damaged"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "damaged"),
        (HEADER % (b"ascii", 3, 2) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1\n", "row of other values: '3 0 1'"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "row of other values"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2 2\n", "row of other values"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1.7 2\n", "row of other values"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n", "row of other values"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "vertices: expected finite"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "polygons: expected indices below 3"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "polygons: expected"),
        (HEADER % (b"ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n", "expected 4 lines of values, found 3"),
        (HEADER % (b"ascii", 3, 0) + b"0 0 0\n1 0 0\n0 1 0\n", "expected a mesh with vertices and faces"),
        (HEADER % (b"ascii", 0, 0), "expected a mesh with vertices and faces"),
        (HEADER % (b"binary_little_endian", 3, 1) + bytes(36) + b"\xff" * 5, "expected a PLY file"),
        (HEADER.replace(b"uchar", b"uint") % (b"binary_little_endian", 3, 1) + bytes(36) + b"\xff" * 4, "a PLY file"),
        (HEADER.replace(b"float x", b"thing x") % (b"ascii", 0, 0), "expected a PLY file"),
    ],
)
def test_damaged_plys(tmp_path, data, words):
    (tmp_path / "a.ply").write_bytes(data)
    refused(tmp_path / "a.ply", words)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (bytes(80) + struct.pack("<I", 10**9) + bytes(500), "expected an STL file"),
        (bytes(80) + struct.pack("<I", 0), "expected a mesh with triangles"),
        (bytes(80) + struct.pack("<I", 1) + bytes(50), "vertices: expected"),
        (bytes(80) + struct.pack("<I", 2) + bytes(50), "truncated"),
        (bytes(80) + struct.pack("<I", 1) + struct.pack("<12f", *[np.nan] * 12) + bytes(2), "vertices: expected"),
        (b"solid a\nendsolid a\n", "expected a mesh with triangles, found none"),
        (b"solid\nendsolid\nendsolid a\nsolid a\n", "expected"),
        (b"solid a\nvertex 0 0 0\nvertex 1 0 0\nendsolid a\n", "expected an STL file, found a damaged one"),
        (b"solid a\nvertex 0 0 0\nvertex 1 0 x\nvertex 0 1 0\nendsolid a\n", "expected an STL file, found a damaged"),
        (b"solid a\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 1 0\nvertex 5 5 5\nvertex 6 5 5\nvertex 6 6 5\nendsolid\n",
         "expected distinct corners"),
        (b"solid\nendsolid\n" * 2000, "at most 1024 solids"),
        (b"hello", "expected an STL file, found something else"),
    ],
)  # fmt: skip
def test_damaged_stls(tmp_path, data, words):
    (tmp_path / "a.stl").write_bytes(data)
    refused(tmp_path / "a.stl", words)


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_numbers_that_signal_are_refused_without_a_warning(ball_mesh, tmp_path, suffix, recwarn):
    path = tmp_path / f"a{suffix}"
    write_mesh(path, ball_mesh)
    data = bytearray(path.read_bytes())
    start = 96 if suffix == ".stl" else data.index(b"end_header\n") + 11
    data[start : start + 4] = b"\x01\x00\x80\x7f"
    path.write_bytes(data)
    refused(path, "expected finite")
    assert not recwarn.list


def test_triangles_are_capped(ball_mesh, tmp_path, monkeypatch):
    triangles = trimesh.Trimesh(ball_mesh.vertices, ball_mesh.faces, process=False)
    (tmp_path / "a.stl").write_text(trimesh.exchange.stl.export_stl_ascii(triangles))
    write_mesh(tmp_path / "b.stl", ball_mesh)
    monkeypatch.setattr(stl, "MAX_POLYGONS", 100)
    for name in ("a.stl", "b.stl"):
        refused(tmp_path / name, "expected at most 100 triangles, found 596")


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
@pytest.mark.parametrize("protocol", range(6))
def test_pickles_are_refused_and_never_run(tmp_path, suffix, protocol):
    class Bomb:
        def __reduce__(self):
            return (open, (str(tmp_path / "ran"), "w"))

    (tmp_path / f"a{suffix}").write_bytes(pickle.dumps([Bomb(), bytes(100)], protocol))
    refused(tmp_path / f"a{suffix}", "expected", *(["a pickle"] if protocol >= 2 else []))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_a_file_of_another_format_is_refused(ball_mesh, tmp_path, suffix):
    for other in OTHERS:
        write_mesh(tmp_path / f"a{other}", ball_mesh)
        if {suffix, other} not in ({suffix}, {".glb", ".gltf"}):
            (tmp_path / f"b{suffix}").write_bytes((tmp_path / f"a{other}").read_bytes())
            refused(tmp_path / f"b{suffix}", "expected")


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_files_are_capped(ball_mesh, tmp_path, suffix):
    write_mesh(tmp_path / f"a{suffix}", ball_mesh)
    os.truncate(tmp_path / f"a{suffix}", MAX_FILE_BYTES + 1)  # a hole, which takes no place on the disk
    refused(tmp_path / f"a{suffix}", "of at most", f"found {MAX_FILE_BYTES + 1} bytes")


def test_trimesh_is_not_imported_before_it_is_needed(tmp_path):
    write_mesh(tmp_path / "a.obj", quads())
    code = (
        "import sys; from caricli.io.meshes.mesh import read_mesh; read_mesh(sys.argv[1]); "
        "sys.exit('trimesh' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code, tmp_path / "a.obj"]).returncode == 0


def test_what_trimesh_writes_is_read(ball_mesh, tmp_path):
    triangles = trimesh.Trimesh(ball_mesh.vertices, ball_mesh.faces, process=False)
    for suffix in ("ply", "stl", "glb"):
        triangles.export(tmp_path / f"a.{suffix}")
        back = read_mesh(tmp_path / f"a.{suffix}")
        np.testing.assert_allclose(back.vertices[back.faces], ball_mesh.vertices[ball_mesh.faces], atol=1e-6)
    assert b"_SOURCE_VERTEX" not in (tmp_path / "a.glb").read_bytes()


def test_meshes_of_a_folder_are_its_obj_files_or_else_the_others(ball_mesh, tmp_path):
    for name in ("b.ply", "a.ply", "c.glb"):
        write_mesh(tmp_path / name, ball_mesh)
    assert [path.name for path in mesh_files(tmp_path)] == ["a.ply", "b.ply"]
    write_mesh(tmp_path / "d.obj", ball_mesh)
    assert [path.name for path in mesh_files(tmp_path)] == ["d.obj"]
    (tmp_path / "empty").mkdir()
    assert mesh_files(tmp_path / "empty") == []
    with pytest.raises(InputError, match="expected a folder of OBJ files or other meshes"):
        mesh_files(tmp_path / "d.obj")


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_pictures_of_other_materials_are_embedded_where_polygons_wear_them(full_rig, tmp_path, suffix):
    pictures = full_rig.pictures
    write_png(tmp_path / "skin.png", pictures.skin)
    write_png(tmp_path / "eyes.png", pictures.eyes)
    others = {"eyes": "eyes.png"}
    for materials, expected in ((full_rig.materials, pictures.eyes), (None, None)):
        path = tmp_path / f"{materials is None}{suffix}"
        write_mesh(path, full_rig.mesh, "skin.png", others=others, materials=materials)
        back = read_gltf(path).pictures
        np.testing.assert_array_equal(back.skin, pictures.skin)
        np.testing.assert_array_equal(back.eyes, expected)
    write_mesh(tmp_path / f"none{suffix}", full_rig.mesh, "skin.png", materials=full_rig.materials)
    assert read_gltf(tmp_path / f"none{suffix}").pictures.eyes is None
