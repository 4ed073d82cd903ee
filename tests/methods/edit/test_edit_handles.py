import numpy as np
import pytest

from caricli.geometry.repair.self_intersections import self_intersections
from caricli.methods.edit.deform_arap import deform_arap
from caricli.methods.edit.edit_handles import HandleSettings, _crossing, edit_handles
from caricli.methods.edit.handle_figures import handle_figures
from caricli.methods.edit.handle_points import Handles, vertex_of
from caricli.methods.faces.encode_face import encode_face
from caricli.models.pca.model import PcaModel
from caricli.structures import Camera, Face, Mesh
from caricli.template.annotation import Annotation
from caricli.template.template import Template


def encoded(vertices, model, **more):
    return encode_face(Face(model.template.with_vertices(vertices), **more), model)


@pytest.fixture(scope="module")
def face(strangers, kernel):
    return encoded(strangers[1], kernel)


def handles_of(model, names, displacements):
    vertices = np.array([vertex_of(name, model.template) for name in names])
    return Handles(vertices, np.array(displacements, float), tuple(names))


def pull(face, model, displacement, name="nose_tip", **options):
    return edit_handles(face, model, handles_of(model, [name], [displacement]), **options)


@pytest.mark.parametrize("norm", [1, 2])
@pytest.mark.parametrize(
    ("names", "ways"),
    [
        (["nose_tip"], [[0, 0, 1]]),
        (["chin"], [[0, -1, 0]]),
        (["ear_left", "ear_right"], [[1, 0, 0], [-1, 0, 0]]),
        (["cheekbone_left", "cheekbone_right"], [[1, 0, 0], [-1, 0, 0]]),
    ],
)
def test_handles_go_where_they_are_asked_to_and_little_else_moves(face, kernel, names, ways, norm):
    asked = 0.05 * kernel.template.height * np.array(ways, float)
    edit = edit_handles(face, kernel, handles_of(kernel, names, asked), HandleSettings(norm))
    assert np.linalg.norm(edit.achieved - asked, axis=1).max() < 0.05 * np.linalg.norm(asked[0])
    assert edit.elsewhere < 0.2 and edit.share == 1
    assert edit.flipped[1] <= edit.flipped[0]
    moved = np.linalg.norm(edit.face.vertices - face.vertices, axis=1)
    assert moved.max() < 2 * np.linalg.norm(asked[0])


def test_no_displacement_changes_nothing(face, kernel):
    edit = pull(face, kernel, np.zeros(3))
    assert np.array_equal(edit.face.vertices, face.vertices) and np.array_equal(edit.face.latent, face.latent)


def test_a_pin_stays(face, kernel):
    handles = handles_of(kernel, ("chin", "l6"), [[0, -0.012, 0], [0.0, 0, 0]])
    held = edit_handles(face, kernel, handles)
    free = pull(face, kernel, handles.displacements[0], "chin")
    stays, goes = held.achieved[1], (free.face.vertices - face.vertices)[handles.vertices[1]]
    assert np.linalg.norm(stays) < 1e-4 < 2e-4 < np.linalg.norm(goes)


def test_what_the_latent_cannot_express_stays(face, strangers, kernel):
    """A wart far from the handle is there before and after."""
    bumpy = strangers[1].copy()
    spot = int(vertex_of("forehead", kernel.template))
    bumpy[spot, 2] += 0.005
    plain, edit = (pull(each, kernel, [0, 0, 0.01]) for each in (face, encoded(bumpy, kernel)))
    difference = edit.face.vertices - plain.face.vertices
    assert difference[spot, 2] == pytest.approx(0.005, abs=1e-3)
    assert np.abs(np.delete(difference, spot, 0)).mean() < 2e-4


def test_the_first_norm_leaves_more_of_the_latent_alone(face, kernel):
    changes = []
    for norm in (1, 2):
        settings = HandleSettings(norm, keep=0.0)
        edit = pull(face, kernel, [0, 0, 0.012], settings=settings)
        changes.append(np.abs(kernel.prior.whiten(edit.face.latent) - kernel.prior.whiten(face.latent)))
    assert changes[0].sum() < changes[1].sum()
    assert np.median(changes[0]) < 0.3 * np.median(changes[1])


def test_an_edit_is_shortened_before_the_surface_crosses_itself(head_template, kernel):
    """The chin goes up through the mouth."""
    face = encoded(head_template.vertices, kernel)
    asked = [0, 0.3 * kernel.template.height, 0]
    reckless, careful = (pull(face, kernel, asked, "chin", avoid=avoid) for avoid in (False, True))
    assert reckless.share == 1 and 0 < careful.share < 1
    crossing = [len(self_intersections(edit.face.vertices, kernel.template.faces)) for edit in (reckless, careful)]
    assert crossing[0] > 0 == crossing[1]
    height = careful.achieved[0, 1]
    assert height == pytest.approx(careful.share * asked[1], rel=0.1)


def test_what_crossed_before_shortens_nothing(face, kernel):
    assert len(self_intersections(face.vertices, face.faces))
    for forward in (0.001, 0.012):
        assert pull(face, kernel, [0, 0, forward], avoid=True).share == 1


def test_surfaces_that_stand_in_each_other_do_not_cross():
    """As lashes do in lids; one that goes through itself does."""
    wall = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    blade = np.array([[0.2, 0.2, -1], [0.3, 0.2, 1], [0.2, 0.3, 1]])
    apart = Face(Mesh(np.concatenate([wall, blade]), np.arange(6).reshape(2, 3)))
    assert not len(_crossing(apart))
    bridge = np.array([[2, 6, 5]])
    joined = Mesh(np.concatenate([wall, blade, [[0, 3, 0]]]), np.concatenate([apart.faces, bridge]))
    assert _crossing(Face(joined)).tolist() == [0, 1]


def test_a_face_stays_where_it_is(face, kernel):
    elsewhere = encode_face(face.with_vertices(face.vertices + 0.3), kernel)
    here, there = (pull(each, kernel, [0, 0, 0.01]).face.vertices for each in (face, elsewhere))
    np.testing.assert_allclose(there - 0.3, here, atol=1e-6)


def test_vertices_may_have_any_order(strangers, pca):
    order = np.random.default_rng(0).permutation(len(pca.mean))
    moved = []
    for own in (np.arange(len(order)), order):
        numbers = np.argsort(own)
        note = Annotation(numbers[pca.template.annotation.landmarks], (), {}, {}, None, {}, {})
        template = Template(pca.template.vertices[own], numbers[pca.template.faces], annotation=note)
        model = PcaModel(template, pca.mean[own], pca.basis[:, own])
        tip = numbers[[vertex_of("nose_tip", pca.template)]]
        handles = Handles(tip, np.array([[0, 0, 0.02]]), ("nose_tip",))
        edit = edit_handles(encoded(strangers[1][own], model), model, handles)
        moved.append(edit.face.vertices[numbers])
    np.testing.assert_allclose(moved[1], moved[0], atol=1e-6)


def test_camera_and_landmarks_travel_with_the_face(strangers, kernel):
    camera = Camera(900.0, np.diag([1.0, -1, -1]), np.ones(2))
    given = encoded(strangers[1], kernel, camera=camera, landmarks=np.zeros((68, 2)))
    for displacement in ([0, 0, 0.01], [0, 0, 0.0]):
        edited = pull(given, kernel, displacement).face
        assert edited.camera is camera and edited.landmarks is given.landmarks


def test_figures_of_handles_that_move_and_stay(face, kernel):
    edit = edit_handles(face, kernel, handles_of(kernel, ("chin", "l6"), [[0, -0.012, 0], [0.0, 0, 0]]))
    figures = handle_figures(edit, face)
    chin, pin = figures["handles"]
    assert chin["where"] == "chin" and chin["vertex"] == edit.handles.vertices[0]
    assert chin["reached"] == edit.reached[0] == pytest.approx(1, abs=0.05)
    assert np.isnan(edit.reached[1]) and "reached" not in pin
    assert figures["flipped_triangles"] == {"before": edit.flipped[0], "after": edit.flipped[1]}
    assert figures["crossing_pairs"]["before"] == len(self_intersections(face.vertices, face.faces))
    assert np.array_equal(edit.tried.displacements, edit.handles.displacements)


def test_as_rigid_as_possible_moves_a_free_ball_and_bends_a_held_one(ball):
    vertices, faces = ball
    top, bottom = vertices[:, 2].argmax(), vertices[:, 2].argmin()
    moved = deform_arap(vertices, faces, [top], np.array([[0, 0, 0.3]])) - vertices
    assert np.abs(moved - [0, 0, 0.3]).max() < 0.02
    held = deform_arap(vertices, faces, [top, bottom], np.array([[0, 0, 0.3], [0, 0, 0]])) - vertices
    assert np.allclose(held[[top, bottom]], [[0, 0, 0.3], [0, 0, 0]])
    assert np.linalg.norm(held - held.mean(0), axis=1).max() > 0.1


def test_as_rigid_as_possible_takes_other_components_along(ball):
    vertices, faces = ball
    both = np.concatenate([vertices, 0.2 * vertices + [0, 0, 1.5]])
    top = vertices[:, 2].argmax()
    moved = deform_arap(both, np.concatenate([faces, faces + len(vertices)]), [top], np.array([[0, 0.3, 0]])) - both
    np.testing.assert_allclose(moved[len(vertices) :], np.broadcast_to([0, 0.3, 0], vertices.shape), atol=0.03)
