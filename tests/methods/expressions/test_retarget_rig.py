import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.expressions.retarget_expression import Explanation, RetargetSettings
from caricli.methods.expressions.retarget_rig import DrivingLandmarks, DrivingMesh, Retargeting, retarget_rig
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.store.models import load_model
from caricli.structures import Mesh, Rig
from caricli.template.head_parts import part_lips

NAMES = ("jawOpen", "mouthSmileLeft", "browInnerUp", "eyeBlinkLeft")


@pytest.fixture(scope="module")
def rig(ball, head):
    vertices, faces = ball
    own = 0.02 * np.random.default_rng(4).normal(size=(4, *vertices.shape))
    deltas = head.actions[[head.action_names.index(name) for name in NAMES]]
    return Rig(NAMES, Mesh(vertices.astype(np.float32), faces), own.astype(np.float32), normal_deltas=deltas)


@pytest.fixture
def retargeting(rig, head_template):
    weights = np.array([[0.6, 0.2, 0.1, 0.9], [0, 0, 0, 0.01]])
    explanation = Explanation(weights, head_template.vertices, np.array([0.5, 1.25]))
    return Retargeting(rig, head_template, explanation, "mm")


def test_a_driver_and_the_caricature_that_does_the_same(retargeting, rig, head_template):
    moved = np.tensordot(retargeting.explanation.weights[0], rig.deltas, 1)
    np.testing.assert_allclose(retargeting.caricature(0).vertices, rig.neutral + moved, atol=1e-6)
    normal = np.tensordot(retargeting.explanation.weights[0], rig.normal_deltas, 1)
    np.testing.assert_allclose(retargeting.driver(0).vertices, head_template.vertices + normal)
    animation = retargeting.animation(10)
    np.testing.assert_allclose(animation.times, [0, 0.1])
    np.testing.assert_array_equal(animation.weights, retargeting.explanation.weights)


def test_what_is_said_of_it(retargeting):
    assert (
        retargeting.describe(0)
        == "eyeBlinkLeft 0.90, jawOpen 0.60, mouthSmileLeft 0.20 and 1 more; 0.50 mm unexplained"
    )
    assert retargeting.describe(1) == "no expression; 1.25 mm unexplained"
    assert retargeting.figures(1) == {"weights": dict(zip(NAMES, [0, 0, 0, 0.01], strict=True)), "left_mm": 1.25}
    assert retargeting.weights_by_name()["jawOpen"] == [0.6, 0.0]


def test_a_rig_that_does_not_know_a_normal_face_is_refused(rig, head_template):
    plain = Rig(rig.names, rig.mesh, rig.deltas)
    with pytest.raises(InputError, match="to a normal face, found none; caricli blendshapes"):
        retarget_rig([DrivingMesh(head_template.vertices)], plain, load_model(kind="morphable"))


def test_lips_close_on_an_open_jaw_and_no_more_than_it_is(head, head_template, ball):
    names = ("mouthClose", "jawOpen", "browInnerUp")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    vertices, faces = ball
    rig = Rig(names, Mesh(vertices.astype(np.float32), faces), np.zeros((3, *vertices.shape)), normal_deltas=deltas)
    model = load_model(kind="morphable")
    neutral = model.template.vertices
    drivers = [DrivingMesh(neutral + np.tensordot(w, deltas, 1)) for w in ([0.5, 0.8, 0.3], [0.4, 0, 0])]
    weights = retarget_rig(drivers, rig, model, neutral).explanation.weights
    np.testing.assert_allclose(weights[0], [0.5, 0.8, 0.3], atol=0.01)
    # Lips that push through each other are no expression of anybody's.
    assert (weights[:, 0] <= weights[:, 1] + 1e-9).all()
    wild = [DrivingMesh(neutral + np.tensordot([1.3, 1.8, 0], deltas, 1))]
    assert retarget_rig(wild, rig, model, neutral).explanation.weights.max() <= RetargetSettings.strongest


def test_lids_squint_only_as_far_as_a_blink_leaves_them_open(head, ball):
    names = ("eyeSquintLeft", "eyeBlinkLeft")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    vertices, faces = ball
    rig = Rig(names, Mesh(vertices.astype(np.float32), faces), np.zeros((2, *vertices.shape)), normal_deltas=deltas)
    model = load_model(kind="morphable")
    neutral = model.template.vertices
    done = [[0.5, 0.2], [1, 0.9], [1, 1.3]]
    drivers = [DrivingMesh(neutral + np.tensordot(weights, deltas, 1)) for weights in done]
    weights = retarget_rig(drivers, rig, model, neutral).explanation.weights
    np.testing.assert_allclose(weights, [[0.5, 0.2], [0.3, 0.9], [0, 1.3]], atol=0.01)


def test_landmarks_let_no_tongue_out(head, ball):
    names = ("tongueOut", "mouthUpperUpLeft", "mouthUpperUpRight")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    deltas[0] += part_lips(head.action_names, head.actions.astype(float))
    vertices, faces = ball
    rig = Rig(names, Mesh(vertices.astype(np.float32), faces), np.zeros((3, *vertices.shape)), normal_deltas=deltas)
    model = load_model(kind="morphable")
    open_ = model.template.vertices + deltas[0]
    points = open_[model.template.annotation.landmarks[:68], :2] * [1500, -1500] + [300, 310]
    seen = retarget_rig([DrivingLandmarks(points, fit_morphable(points, model))], rig, model).explanation.weights
    assert seen[0, 0] == 0
    # A mesh of a neutral face that is given shows how far lips part for it.
    meshes = retarget_rig([DrivingMesh(open_)], rig, model, model.template.vertices).explanation.weights
    np.testing.assert_allclose(meshes[0], [1, 0, 0], atol=0.01)


def test_landmarks_turn_no_eyes(head, ball):
    names = ("eyeLookUpLeft", "eyeWideLeft", "browInnerUp")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    vertices, faces = ball
    spelt = ("EyeLookUpLeft", "eyeWide_L", "browInnerUp")
    rig = Rig(spelt, Mesh(vertices.astype(np.float32), faces), np.zeros((3, *vertices.shape)), normal_deltas=deltas)
    model = load_model(kind="morphable")
    up = model.template.vertices + deltas.sum(0)
    points = up[model.template.annotation.landmarks[:68], :2] * [1500, -1500] + [300, 310]
    seen = retarget_rig([DrivingLandmarks(points, fit_morphable(points, model))], rig, model).explanation.weights
    # Lids are as high as those of an eye that looks up, or of a wide one; the iris has no landmark.
    assert seen[0, 0] == 0 and seen[0, 1] > 0.5
    meshes = retarget_rig([DrivingMesh(up)], rig, model, model.template.vertices).explanation.weights
    np.testing.assert_allclose(meshes[0], [1, 1, 1], atol=0.01)


def test_wide_jaws_do_not_go_to_both_sides_at_once(head, ball):
    names = ("jawLeft", "jawRight", "jawOpen")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    vertices, faces = ball
    rig = Rig(names, Mesh(vertices.astype(np.float32), faces), np.zeros((3, *vertices.shape)), normal_deltas=deltas)
    model = load_model(kind="morphable")
    wide = model.template.vertices + 1.2 * deltas[0] + 0.9 * deltas[1] + 0.5 * deltas[2]
    points = wide[model.template.annotation.landmarks[:68], :2] * [1500, -1500] + [300, 310]
    landmarks = retarget_rig([DrivingLandmarks(points, fit_morphable(points, model))], rig, model)
    mesh = retarget_rig([DrivingMesh(wide)], rig, model)
    for seen in (landmarks, mesh):
        left, right, open_ = seen.explanation.weights[0]
        assert right < 1e-5 and 0.05 < left < 1 and open_ > 0.3
    # A mesh of a neutral face that is given shows that it does.
    given = retarget_rig([DrivingMesh(wide)], rig, model, model.template.vertices).explanation.weights
    np.testing.assert_allclose(given[0], [1.2, 0.9, 0.5], atol=0.01)
