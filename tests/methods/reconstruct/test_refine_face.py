from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces.encode_face import decode_face, encode_face
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.refine_face import refine_face
from caricli.methods.reconstruct.settings import RefineSettings
from caricli.structures import Camera, Face
from caricli.structures.landmarks import PARTS

VIEWS = ((0, 0, 0), (5, 30, 10), (-10, -20, 0), (0, 15, -30), (10, -45, 5), (0, 0, 90))


@pytest.fixture(scope="module")
def template(intrinsic):
    return intrinsic.template


@pytest.fixture(scope="module")
def pairs(strangers, seen):
    """(Truth of a stranger, its number): coarse is always the template, in the stranger's own camera."""
    return [seen(stranger, *view) for stranger, view in zip(strangers, VIEWS, strict=True)]


@pytest.fixture(scope="module")
def refined(pairs, template):
    """Refinements of the template to every one of them."""
    return [refine_face(Face(template, truth.camera), truth.points, template) for truth in pairs]


@pytest.mark.parametrize(("number", "laplacian"), [*((k, "cotangent") for k in range(6)), (2, "uniform")])
def test_a_consistent_target_changes_nothing(number, laplacian, strangers, pairs, template):
    truth, face = pairs[number], strangers[number]
    assert number != 2 or flipped_triangles(face, template.gradients).any()
    before = face.copy()
    settings = RefineSettings(laplacian=laplacian)
    found = refine_face(Face(template.with_vertices(face), truth.camera), truth.points, template, settings)
    assert np.abs(found.face.vertices - face).max() < 1e-6 * template.height
    assert found.before["all"] < 1e-6 and found.after["all"] < 1e-6 and found.moved < 1e-6 * template.height
    np.testing.assert_array_equal(face, before)


@pytest.mark.parametrize("number", range(6))
def test_synthetic_faces_are_met_by_a_sound_surface(number, pairs, refined, template):
    truth, found = pairs[number], refined[number]
    assert found.after["all"] <= 0.3 < 2 < found.before["all"]
    assert found.after["eyes"] <= found.before["eyes"] / 10
    assert found.flipped <= 0.001
    # The figures are what they say.
    diagonal = np.linalg.norm(np.ptp(truth.points, axis=0))
    np.testing.assert_allclose(found.face.landmarks, truth.camera.project(found.face.vertices[found.anchors]))
    distances = 100 * np.linalg.norm(found.face.landmarks - truth.points, axis=1) / diagonal
    assert found.after["all"] == pytest.approx(distances.mean())
    assert found.after["eyes"] == pytest.approx(distances[PARTS["eyes"]].mean())
    assert found.flipped == flipped_triangles(found.face.vertices, template.gradients).mean()
    assert found.moved == pytest.approx(np.linalg.norm(found.face.vertices - template.vertices, axis=1).max())


def test_the_mouth_stays_behind_the_skin(pairs, template):
    """A mouth cavity that stands out of the upper lip."""
    truth, cavities = pairs[0], template.cavities
    inside = template.mask("inner_mouth")
    inside[template.annotation.landmarks] = False
    vertices = template.vertices + inside[:, None] * [0, 0.012, 0.02]
    assert np.abs(cavities.tuck(vertices) - vertices).max() > 0.005
    found = refine_face(Face(template.with_vertices(vertices), truth.camera), truth.points, template)
    np.testing.assert_allclose(cavities.tuck(found.face.vertices), found.face.vertices, atol=1e-3)
    assert found.after["all"] <= 0.3


def test_uniform_meets_them_too(pairs, template):
    for truth in pairs[1:3]:
        face = Face(template, truth.camera)
        found = refine_face(face, truth.points, template, RefineSettings(laplacian="uniform"))
        upright = refine_face(face, truth.points, template, RefineSettings(laplacian="uniform", rounds=0))
        assert upright.after["all"] < 0.5 * upright.before["all"]
        assert np.abs(upright.face.vertices - found.face.vertices).max() > 1e-4
        assert found.after["all"] <= 0.3 and found.after["eyes"] <= found.before["eyes"] / 10
        # Behind a lid that came down, the lining of its eye folds.
        lining = template.mask("eye_socket_left", "eye_socket_right")[template.faces].all(1)
        turned = flipped_triangles(found.face.vertices, template.gradients)
        assert turned[~lining].mean() <= 0.001 and found.flipped <= 0.002


def test_the_truth_comes_nearer(refined, strangers, template):
    errors = []
    for found, stranger in zip(refined, strangers, strict=True):
        errors.append([np.linalg.norm(v - stranger, axis=1).mean() for v in (template.vertices, found.face.vertices)])
    errors = np.array(errors)
    assert errors[:, 1].mean() < 0.97 * errors[:, 0].mean(), errors


def test_anchors_keep_their_depth(pairs, template):
    for truth in pairs[1:3]:
        found = refine_face(Face(template, truth.camera), truth.points, template, RefineSettings(weight=1e4))
        change = (found.face.vertices - template.vertices)[found.anchors] @ truth.camera.rotation.T
        assert np.abs(change[:, 2]).max() < 1e-5 < np.abs(change[:, :2]).max()


@pytest.mark.parametrize("angle", [0, 35])
def test_picture_and_camera_moved_together_move_nothing(angle, pairs, refined, template):
    truth, here = pairs[1], refined[1]
    turn = rotation_matrices(np.radians([[0, 0, angle]]))[0]
    points = 0.37 * truth.points @ turn[:2, :2].T + [-40.0, 900.0]
    translation = 0.37 * turn[:2, :2] @ truth.camera.translation + [-40.0, 900.0]
    camera = Camera(0.37 * truth.camera.scale, turn @ truth.camera.rotation, translation)
    there = refine_face(Face(template, camera), points, template)
    np.testing.assert_allclose(there.face.vertices, here.face.vertices, atol=1e-7)
    landmarks = 0.37 * here.face.landmarks @ turn[:2, :2].T + [-40.0, 900.0]
    np.testing.assert_allclose(there.face.landmarks, landmarks, atol=1e-4)


def test_a_larger_weight_is_more_exact(pairs, template):
    truth = pairs[0]
    errors = [
        refine_face(Face(template, truth.camera), truth.points, template, RefineSettings(weight=weight)).after["all"]
        for weight in (0.01, 1.0, 100.0)
    ]
    assert errors[0] > errors[1] > errors[2]


def test_what_is_not_known_pulls_at_nothing(pairs, template):
    truth = pairs[0]
    points = truth.points.copy()
    points[48:68] = np.nan
    found = refine_face(Face(template, truth.camera), points, template)
    assert "mouth" not in found.after and set(found.after) == {"jaw", "brows", "nose", "eyes", "all"}
    assert found.after["all"] < 0.3 and np.isfinite(found.face.vertices).all() and len(found.face.landmarks) == 68


def test_all_81_landmarks(strangers, seen, template):
    truth = seen(strangers[0], yaw=10, count=81)
    found = refine_face(Face(template, truth.camera), truth.points, template)
    assert found.after["extra"] < 0.3 and len(found.anchors) == 81


@pytest.mark.parametrize("kind", ["intrinsic", "kernel"])
def test_the_residual_takes_up_what_moved(kind, request, pairs, template):
    model, truth = request.getfixturevalue(kind), pairs[4]
    coarse = encode_face(Face(template, truth.camera), model)
    refinement = refine_face(coarse, truth.points, template)
    found, code = refinement.face, refinement.face_of(model)
    assert found.residual is None
    np.testing.assert_array_equal(code.latent, coarse.latent)
    assert np.abs(code.residual - coarse.residual).max() > 1e-3 and code.model_id == model.model_id
    np.testing.assert_allclose(decode_face(code, model, code.shift).vertices, found.vertices, atol=1e-6)
    np.testing.assert_array_equal(code.camera.rotation, truth.camera.rotation)


def test_a_face_without_a_latent_gets_no_residual(pairs, refined, intrinsic):
    other = replace(refined[0], face=replace(refined[0].face, model_id="some"))
    bare = other.face_of(intrinsic)
    assert bare.latent is bare.residual is bare.model_id is None and bare.camera is pairs[0].camera


def test_a_face_of_no_picture_is_refused(pairs, template):
    with pytest.raises(InputError, match="expected a face with the camera of its picture"):
        refine_face(Face(template), pairs[0].points, template)


def upwards(camera):
    up = camera.rotation[:2, 1]
    return up / np.linalg.norm(up)


@pytest.mark.parametrize(("upper", "lower"), [(37, 41), (62, 66)])
def test_lids_and_lips_that_cross_a_little_meet(upper, lower, pairs, template):
    for truth in pairs[:2]:
        points = truth.points.copy()
        middle = points[[upper, lower]].mean(0)
        passed = 0.004 * np.linalg.norm(np.ptp(points, axis=0)) * upwards(truth.camera)
        points[upper], points[lower] = middle - passed, middle + passed
        found = refine_face(Face(template, truth.camera), points, template, RefineSettings(weight=1e4))
        np.testing.assert_allclose(found.face.landmarks[[upper, lower]], [middle, middle], atol=0.05)


@pytest.mark.parametrize(("upper", "lower"), [(37, 41), (63, 65)])
def test_lids_and_lips_that_cross_much_are_refused(upper, lower, pairs, template):
    for truth in pairs[:2]:
        points = truth.points.copy()
        up = 0.08 * np.linalg.norm(np.ptp(points, axis=0)) * upwards(truth.camera)
        points[lower] = points[upper] + up
        with pytest.raises(InputError, match=f"landmarks {upper} and {lower}: expected the upper above the lower"):
            refine_face(Face(template, truth.camera), points, template)


@pytest.mark.parametrize(("a", "b"), [(8, 9), (30, 33), (37, 38), (36, 45)])
def test_landmarks_in_one_place_are_refused(a, b, pairs, template):
    points = pairs[0].points.copy()
    points[b] = points[a]
    with pytest.raises(InputError, match=f"expected landmarks in different places, found {a} and {b} in one"):
        refine_face(Face(template, pairs[0].camera), points, template)


def test_closed_eyes_and_mouths_may_be_in_one_place(pairs, template):
    points = pairs[0].points.copy()
    for a, b in ((37, 41), (38, 40), (43, 47), (44, 46), (61, 67), (62, 66), (63, 65)):
        points[[a, b]] = points[[a, b]].mean(0)
    points[60], points[64] = points[48], points[54]
    found = refine_face(Face(template, pairs[0].camera), points, template)
    assert found.after["all"] < 0.5 and found.flipped <= 0.002


def test_landmarks_of_another_picture_are_refused(pairs, template):
    truth = pairs[0]
    for points in (truth.points + [400.0, 0], 3 * truth.points):
        with pytest.raises(InputError, match="expected landmarks of the picture that the face was fitted to"):
            refine_face(Face(template, truth.camera), points, template)


def test_another_number_of_landmarks_is_refused(pairs, template):
    with pytest.raises(InputError, match="expected 68 or 81 landmarks, found 70"):
        refine_face(Face(template, pairs[0].camera), np.zeros((70, 2)), template)


def test_one_vertex_cannot_be_in_two_places(pairs, template):
    landmarks = template.annotation.landmarks.copy()
    landmarks[60] = landmarks[48]
    shared = replace(template, annotation=replace(template.annotation, landmarks=landmarks))
    points = pairs[0].points.copy()
    points[60] = points[48] + 0.001
    found = refine_face(Face(template, pairs[0].camera), points, shared)
    assert found.after["all"] < 0.3
    points[60] = points[48] + [0, 0.05 * np.linalg.norm(np.ptp(points, axis=0))]
    with pytest.raises(InputError, match=f"expected one place for every vertex, found vertex {landmarks[48]} wanted"):
        refine_face(Face(template, pairs[0].camera), points, shared)


def test_a_landmark_is_met_as_far_as_it_is_surer_than_the_face(pairs, refined, template):
    truth = pairs[0]
    face = Face(template, truth.camera)
    exact, vague = (np.tile(size * np.eye(2), (len(truth.points), 1, 1)) for size in (1e-12, 1e12))
    met = refine_face(face, truth.points, template, spreads=exact)
    np.testing.assert_allclose(met.face.vertices, refined[0].face.vertices, atol=1e-6)
    left = refine_face(face, truth.points, template, spreads=vague)
    assert left.moved < 1e-5 and left.after["all"] == pytest.approx(left.before["all"], rel=1e-3)
    mixed = np.where(np.isin(np.arange(len(truth.points)), PARTS["jaw"])[:, None, None], vague, exact)
    part = refine_face(face, truth.points, template, spreads=mixed)
    assert part.after["eyes"] < 0.1 * part.before["eyes"] and part.after["jaw"] > 0.5 * part.before["jaw"]


@pytest.mark.parametrize(("pitch", "yaw"), [(6, 58), (10, 50)])
def test_a_jaw_that_slides_together_is_met_on_both_sides(pitch, yaw, template):
    """Where two landmarks would slide to one vertex, none is sought behind the outline."""
    moved = []
    for side in (1, -1):
        rotation = head_rotation(np.radians([pitch, side * yaw, 0]))
        camera = Camera(300 / template.height, rotation, np.array([250.0, 250.0]))
        points = camera.project(template.vertices[landmark_vertices(template.vertices, rotation, template, 68)])
        jaw = (4, 5, 6) if side > 0 else (12, 11, 10)
        points[jaw[1]] += (points[jaw[2]] - points[jaw[0]]) / 4
        moved.append(refine_face(Face(template, camera), points, template).moved)
    assert max(moved) < 0.006 and moved[0] == pytest.approx(moved[1], rel=0.1)
