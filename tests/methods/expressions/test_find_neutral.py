import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.self_intersections import self_intersections
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.find_neutral import find_neutral
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.rig.measure_rig import curve_gap
from caricli.store.expression_tools import load_neutral_tools
from caricli.structures import Camera, Face, Mesh

PERSON = {"gender": 0.7, "age": 0.6, "weight": 0.3}
LAUGH = {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "jawOpen": 0.5, "eyeSquintLeft": 0.3, "eyeSquintRight": 0.3}
WIDE = [1.1, 0.92, 1.1]


@pytest.fixture(scope="module")
def tools(head_template):
    return load_neutral_tools(head_template)


@pytest.fixture(scope="module")
def shapes(head):
    """(2, V, 3) a caricature at rest, and laughing."""
    return np.array([head.evaluate(**PERSON, actions=actions) * WIDE for actions in ({}, LAUGH)])


@pytest.fixture(scope="module")
def laughing(head_template, shapes):
    """A Face that laughs."""
    camera = Camera(1600.0, head_rotation(np.radians([4.0, 12, -3])), np.array([300.0, 320]))
    return Face(head_template.with_vertices(shapes[1]), camera)


@pytest.fixture(scope="module")
def neutral(laughing, tools):
    return find_neutral(laughing, tools)


def lip_gap(vertices, template):
    curves = (template.annotation.curves[f"mouth_inner_{lip}"] for lip in ("upper", "lower"))
    return curve_gap(vertices[:, :2], *curves)


def lip_crossings(vertices, template):
    mouth = np.concatenate([template.region(name) for name in ("lips", "mouth", "inner_mouth")])
    return len(self_intersections(vertices, template.faces[np.isin(template.faces, mouth).all(1)]))


def test_a_laugh_goes_and_the_lips_neither_gape_nor_cross(neutral, shapes, head_template):
    rest, laugh = shapes
    found = neutral.mesh.vertices
    left, away = (np.linalg.norm(shape - rest, axis=1).mean() for shape in (found, laugh))
    assert left < 0.7 * away and neutral.shown > 1
    assert lip_gap(found, head_template) < 1.5 * lip_gap(rest, head_template) < 0.3 * lip_gap(laugh, head_template)
    assert lip_crossings(found, head_template) <= 4
    assert neutral.moved == np.linalg.norm(found - laugh, axis=1).max()


def test_without_contacts_lips_cross(laughing, head, tools, head_template):
    """Those of a laugh that opens the mouth less than the one above."""
    laugh = head.evaluate(**PERSON, actions=LAUGH | {"jawOpen": 0.3}) * WIDE
    given = Face(head_template.with_vertices(laugh), laughing.camera)
    kept, free = (
        lip_crossings(find_neutral(given, tools, BlendshapeSettings(contacts=contacts)).mesh.vertices, head_template)
        for contacts in (True, False)
    )
    assert free > 2 * kept and free > 4


def test_the_throat_under_a_long_jaw_does_not_turn_over_as_it_closes(laughing, head, tools, head_template):
    """All below the nose is 2.4 times as long."""
    laugh = head.evaluate(**PERSON, actions=LAUGH | {"jawOpen": 0.9})
    nose = laugh[head_template.annotation.landmarks[33], 1]
    laugh[:, 1] += 1.4 * np.minimum(laugh[:, 1] - nose, 0)
    given = Face(head_template.with_vertices(laugh * WIDE), laughing.camera)
    found = find_neutral(given, tools).mesh.vertices
    assert not flipped_triangles(found, head_template.gradients).any()
    assert lip_gap(found, head_template) < 0.3 * lip_gap(given.vertices, head_template)


def test_the_lining_of_a_mouth_that_closes_stays_behind_the_skin(laughing, tools, head_template):
    """That of a laugh in whose picture it came out above the lip."""
    faces = head_template.faces
    lining = np.isin(faces, head_template.region("inner_mouth")).all(1)
    given = laughing.vertices.copy()
    given[np.setdiff1d(faces[lining], faces[~lining]), 2] += 0.012
    found = find_neutral(laughing.with_vertices(given), tools).mesh.vertices
    cavities = head_template.cavities
    assert np.abs(cavities.tuck(given) - given).max() > 0.005
    np.testing.assert_allclose(cavities.withdraw(found), found, atol=1e-6)


def test_a_face_at_rest_stays_as_it_is(shapes, tools, head_template):
    neutral = find_neutral(Face(head_template.with_vertices(shapes[0])), tools)
    np.testing.assert_array_equal(neutral.mesh.vertices, shapes[0])
    assert neutral.moved == 0 and 0 < neutral.shown < 0.55 and "as given" in neutral.describe()


def test_what_no_expression_moves_stays(neutral, shapes, tools):
    np.testing.assert_allclose(neutral.mesh.vertices[tools.actions.still], shapes[1][tools.actions.still], atol=2e-4)


def test_place_size_and_turn_of_a_mesh_without_camera_do_not_matter(shapes, tools, head_template):
    turn = rotation_matrices(np.array([[0.3, -0.4, 0.2]]))[0]
    plain = find_neutral(Face(head_template.with_vertices(shapes[1])), tools).mesh.vertices
    elsewhere = find_neutral(Face(head_template.with_vertices(3 * shapes[1] @ turn.T)), tools).mesh.vertices
    np.testing.assert_allclose(elsewhere, 3 * plain @ turn.T, atol=1e-4)


def test_blendshapes_start_from_the_same_face(neutral, laughing, tools):
    made = build_blendshapes(laughing, tools)
    np.testing.assert_allclose(made.shapes[0], neutral.mesh.vertices, atol=1e-9)


def test_uvs_stay_those_of_the_face(laughing, tools):
    own = np.random.default_rng(0).random(laughing.mesh.uvs.shape)
    mesh = Mesh(laughing.vertices, laughing.mesh.polygons, own, laughing.mesh.uv_polygons)
    np.testing.assert_array_equal(find_neutral(Face(mesh, laughing.camera), tools).mesh.uvs, own)


def test_other_meshes_have_no_tools(ball):
    mesh = Mesh(*ball)
    assert load_neutral_tools(mesh) is None
    assert find_neutral(Face(mesh), None).mesh is mesh
