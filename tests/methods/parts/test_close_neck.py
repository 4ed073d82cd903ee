from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.parts.close_neck import HEIGHT, WIDTH, close_neck, neck_edge, neck_picture, with_neck
from caricli.methods.parts.face_parts import face_parts
from caricli.structures import Face, HeadChoice, Material, Mesh, Pictures
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template
from tests.methods.parts.neck import assert_closed

TRIANGLE = (np.eye(3), np.array([[0, 1, 2]], np.int32))


@pytest.fixture(scope="module", params=[0, 1])
def face(head, head_template, request):
    """A usual head, and one of another size whose neck is anything but even."""
    vertices = head.evaluate(gender=0.2, age=0.8)
    if request.param:
        generator = np.random.default_rng(0)
        edge = neck_edge(head_template)
        vertices = 3 * vertices
        vertices[edge] += 0.02 * generator.normal(size=(len(edge), 3))
    return vertices


def test_there_is_no_gap(head_template, face):
    assert_closed(head_template, face, close_neck(head_template, face))


def test_it_is_below_and_has_a_place_in_its_picture(head_template, face):
    cap = close_neck(head_template, face)
    normals = np.cross(*np.diff(cap.mesh.vertices[cap.mesh.faces], axis=1).transpose(1, 0, 2))
    assert normals[:, 1].sum() < 0 and (cap.materials == Material.BUST).all() and cap.hangs_on == "neck"
    assert (np.linalg.norm(normals, axis=1) > 0).all()
    assert cap.mesh.uvs.min() == 0 and cap.mesh.uvs.max() == 1


def test_a_head_stands_on_a_level_foot(head_template, face):
    places = close_neck(head_template, face).mesh.vertices
    edge = neck_edge(head_template)
    foot = places[-len(edge) - 1 :]
    assert np.ptp(foot[:, 1]) < 1e-12 and (foot[:, 1] < face[:, 1].min()).all()
    middle = face[edge].mean(0)
    widest = np.linalg.norm((face[edge] - middle)[:, [0, 2]], axis=1).max()
    assert np.linalg.norm((foot - middle)[:, [0, 2]], axis=1).max() < 0.5 * widest


def test_the_skin_goes_on_in_its_own_direction(head, head_template):
    """Down from the nape, and not from where it is cut."""
    vertices = head.evaluate(gender=0.2, age=0.8)
    edge = neck_edge(head_template)
    places = close_neck(head_template, vertices).mesh.vertices
    nape = vertices[head_template.mask("neck")]
    above = nape[np.linalg.norm(nape - vertices[edge[0]], axis=1).argsort()[1:9]]
    skin = vertices[edge[0]] - above[above[:, 1].argmax()]
    wall = places[len(edge)] - places[0]
    assert skin @ wall > 0.85 * np.linalg.norm(skin) * np.linalg.norm(wall)


def test_it_moves_with_its_edge(head_template, face):
    shift = np.array([0.01, -0.02, 0.03])
    deltas = np.stack([np.tile(shift, (len(face), 1)), np.zeros_like(face)])
    cap = close_neck(head_template, face, ("moved", "still"), deltas)
    assert cap.names == ("moved", "still")
    np.testing.assert_allclose(cap.deltas[0], np.tile(shift, (len(cap.mesh.vertices), 1)), atol=1e-12)
    assert not cap.deltas[1].any()


def test_it_is_a_part_like_others(head_template, face):
    shown = Face(Mesh(face, head_template.polygons))
    assert [part.name for part in face_parts(shown, head_template, HeadChoice(("skin", "bust")))] == ["neck"]
    assert "neck" in [part.name for part in face_parts(shown, head_template)]
    assert not face_parts(shown, head_template, HeadChoice(("skin", "eyes")))


def test_the_colours_of_its_rim_are_those_of_the_skin(head_template):
    size = 256
    texture = np.zeros((size, size, 3), np.uint8)
    texture[..., 0] = np.linspace(60, 220, size).astype(np.uint8)
    picture = neck_picture(head_template, texture, texture)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    edge = neck_edge(head_template)
    first = head_template.uv_polygons[np.nonzero(head_template.polygons == edge[5])][0]
    expected = np.interp(head_template.uvs[first, 0] * size - 0.5, np.arange(size), texture[0, :, 0])
    at = round(5 / len(edge) * WIDTH - 0.5)
    assert abs(float(picture[0, at, 0]) - expected) < 6
    assert np.ptp(picture[-1].astype(float), axis=0).max() < 0.1 * np.ptp(picture[0].astype(float), axis=0).max()


def test_the_shade_of_hair_ends_at_the_edge(head_template):
    dark, light = np.full((2, 64, 64, 3), [[[[40]]], [[[200]]]], np.uint8)
    picture = neck_picture(head_template, dark, light)
    assert (picture[0] == 40).all() and (picture[HEIGHT // 3 :] == 200).all()


def test_a_neck_without_a_picture_takes_the_colours_of_the_skin(head_template):
    skin, other = np.full((2, 64, 64, 3), [[[[40]]], [[[200]]]], np.uint8)
    assert (with_neck(Pictures(skin), head_template, head_template).bust == 40).all()
    # Its own stays, and of other UVs and meshes nobody knows where its edge lies.
    assert with_neck(Pictures(skin, bust=other), head_template, head_template).bust is other
    elsewhere = replace(head_template, uvs=head_template.uvs[::-1])
    for mesh, template in ((elsewhere, head_template), (Mesh(*TRIANGLE), head_template), (head_template, elsewhere)):
        assert with_neck(Pictures(skin), mesh, template).bust is None
    assert with_neck(Pictures(), head_template, head_template).bust is None


def test_a_neck_is_closed_beside_a_larger_hole(head_template):
    scalp = head_template.mask("scalp")[head_template.polygons].any(1)
    bald = replace(head_template, polygons=head_template.polygons[~scalp], uvs=None, uv_polygons=None)
    np.testing.assert_array_equal(neck_edge(bald), neck_edge(head_template))


def test_a_neck_without_a_name_stays_as_it_is(head_template, face):
    source = {"ibug68": head_template.annotation.source["ibug68"]}
    annotation = parse_annotation(source, len(face), "own.json")
    own = Template(face, head_template.polygons, annotation=annotation)
    assert close_neck(own, face) is None and neck_picture(own, *np.zeros((2, 8, 8, 3), np.uint8)) is None
