from dataclasses import replace

import numpy as np
import pytest

from caricli.data.identities import random_identity
from caricli.errors import InputError, NumericsError
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.measure_blendshapes import measure_blendshapes
from caricli.methods.expressions.normal_pair import _distinct
from caricli.methods.expressions.settings import METHODS, BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.measure_rig import curve_gap
from caricli.models.landmark_map.model import LandmarkMap, align
from caricli.store.landmark_maps import load_landmark_map
from caricli.store.models import load_model
from caricli.structures import Camera, Face
from caricli.structures.landmarks import COUNT
from caricli.template.annotation import DELICATE

EXPRESSIONS = {
    "neutral": {},
    "smile": {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8},
    "open": {"jawOpen": 0.8},
    "blink": {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
    "brows": {"browInnerUp": 1.0, "browOuterUpLeft": 1.0, "browOuterUpRight": 1.0},
}


@pytest.fixture(scope="module")
def actions(head, head_template):
    return head_expressions(head, head_template)


@pytest.fixture(scope="module")
def same():
    """A landmark map that changes nothing."""
    size = 2 * COUNT
    return LandmarkMap(np.zeros(size), np.zeros(size), np.eye(size), np.eye(size)[:1])


@pytest.fixture(scope="module")
def tools(actions):
    """Tools of the expressions, with a model whose latent can follow landmarks."""
    return ExpressionTools(
        actions, EXPRESSIONS, load_model(kind="morphable"), load_landmark_map(), load_model(kind="pca")
    )


@pytest.fixture(scope="module")
def caricature(tools):
    """(K, V, 3) an exaggerated face with every expression."""
    templates = tools.templates
    shapes = (templates.neutral + templates.deltas) * [1.15, 0.9, 1.2]
    return np.stack([exaggerate_curvature(shape, templates.faces, [0.2])[0] for shape in shapes])


@pytest.fixture(scope="module")
def camera():
    return Camera(1600.0, head_rotation(np.radians([4.0, 12, -3])), np.array([300.0, 320]))


@pytest.fixture(scope="module")
def face(caricature, camera, tools):
    """A way to see a shape (V, 3)."""
    return lambda shape, seen=camera: Face(tools.morphable.template.with_vertices(shape), seen)


@pytest.fixture(scope="module")
def built(caricature, face, tools):
    """Blendshapes of the caricature, seen neutral, by method."""
    given = face(caricature[0])
    return {method: build_blendshapes(given, tools, BlendshapeSettings(method)) for method in METHODS}


def errors(made, truth):
    """(K,) of the neutral face, and of what the others do to it."""
    own, true = (np.concatenate([shapes[:1], shapes[1:] - shapes[0]]) for shapes in (made.shapes, truth))
    return np.linalg.norm(own - true, axis=2).mean(1) / np.ptp(truth[0, :, 1])


def test_every_method_comes_nearer_to_the_truth_than_a_face_that_keeps_still(built, caricature):
    still = np.linalg.norm(caricature - caricature[0], axis=2).mean(1) / np.ptp(caricature[0, :, 1])
    for name, made in built.items():
        assert errors(made, caricature)[1:].mean() < 0.65 * still[1:].mean(), name
        assert errors(made, caricature)[0] < 0.006, name


def test_optimised_shapes_drift_less_and_show_no_less(built, caricature):
    found = {
        name: measure_blendshapes(made.shapes[1:] - made.shapes[0], made.normal[1:] - made.normal[0])
        for name, made in built.items()
    }
    drift = {name: np.nanmean(each.drift) for name, each in found.items()}
    assert drift["full"] < 0.5 * min(drift["initial"], drift["transfer"])
    assert 0.8 < np.nanmin(found["full"].strength) and np.nanmax(found["full"].strength) < 1.4


def test_optimised_shapes_of_people_are_nearer_to_the_truth(head, head_template, tools, face):
    """Three people drawn and exaggerated as datasets do it; the mean head above is stretched as nobody is."""
    hold = head_template.mask(*DELICATE).astype(float)
    generator = np.random.default_rng(7)
    people = [random_identity(head, generator) for _ in range(3)]
    found = {"full": 0.0, "initial": 0.0}
    for person in people:
        shapes = [head.evaluate(**vars(person), actions=actions) for actions in EXPRESSIONS.values()]
        truth = np.stack([exaggerate_curvature(shape, head_template.faces, [0.2], hold)[0] for shape in shapes])
        for name in found:
            made = build_blendshapes(face(truth[0]), tools, BlendshapeSettings(name))
            found[name] += errors(made, truth).mean()
    assert found["full"] < 0.95 * found["initial"]


def test_lids_meet_where_contacts_are_kept(built, caricature, face, tools, head_template):
    free = build_blendshapes(face(caricature[0]), tools, BlendshapeSettings(contacts=False))
    blink, note = tools.templates.names.index("blink"), head_template.annotation
    for side in ("left", "right"):
        ids = [note.curves[f"eye_{lid}_{side}"] for lid in ("upper", "lower")]
        usual = curve_gap(caricature[0], *ids)
        assert curve_gap(built["full"].shapes[blink], *ids) < 0.03 * usual < curve_gap(free.shapes[blink], *ids)
        for method, made in built.items():
            assert curve_gap(made.shapes[blink], *ids) < 0.03 * usual, method


def test_lips_close_on_an_open_jaw(head_template, caricature, face, tools):
    both = {"neutral": {}, "mouthClose": {"mouthClose": 1.0}, "jawOpen": {"jawOpen": 1.0}}
    made = build_blendshapes(face(caricature[0]), replace(tools, expressions=both))
    ids = [head_template.annotation.curves[f"mouth_inner_{lip}"] for lip in ("upper", "lower")]
    neutral, close, wide = made.shapes
    assert curve_gap((wide + close - neutral)[:, :2], *ids) < 0.2 * curve_gap(wide[:, :2], *ids)


def test_two_landmarks_of_one_vertex_pull_it_to_their_middle():
    ids, moves = _distinct(np.array([5, 3, 3]), np.array([[1.0, 0], [0, 2], [4, 0]]))
    np.testing.assert_array_equal(ids, [3, 5])
    np.testing.assert_array_equal(moves, [[2, 1], [1, 0]])


def test_an_expression_in_the_picture_is_undone(caricature, face, tools):
    wide = tools.templates.names.index("open")
    made = build_blendshapes(face(caricature[wide]), tools)
    chin, away = (
        tools.morphable.template.annotation.landmarks[5:12],
        np.linalg.norm(caricature[wide] - caricature[0], axis=1),
    )
    left = np.linalg.norm(made.shapes[0] - caricature[0], axis=1)
    assert left[chin].mean() < 0.7 * away[chin].mean()
    assert np.linalg.norm(made.shapes[wide] - caricature[wide], axis=1).mean() < 0.5 * away.mean()


@pytest.mark.parametrize("method", ["full", "initial", "transfer"])
def test_the_size_of_the_face_does_not_matter(built, caricature, camera, face, tools, method):
    smaller = Camera(camera.scale / 3, camera.rotation, camera.translation)
    made = build_blendshapes(face(3 * caricature[0], smaller), tools, BlendshapeSettings(method))
    np.testing.assert_allclose(made.shapes, 3 * built[method].shapes, atol=1e-6)


def stretching(before, after):
    """A landmark map that makes of every face what makes the second face (68, 2) the first one."""
    start, end = (align(points)[0] for points in (after, before))
    affine = np.linalg.lstsq(np.column_stack([start, np.ones(COUNT)]), end, rcond=None)[0]
    size = 2 * COUNT
    normal = np.tile(affine[2], COUNT)
    return LandmarkMap(normal, np.zeros(size), np.kron(np.eye(COUNT), affine[:2]), np.eye(size)[:1])


def test_the_map_finds_the_normal_face_of_a_stretched_one(tools, same):
    """Of a face that is only stretched the right map is known, and a map that changes nothing must do worse."""
    templates, ids = tools.templates, tools.morphable.template.annotation.landmarks[:COUNT]
    stretched = (templates.neutral + templates.deltas) * [1.3, 0.8, 1.2]
    frontal = Camera(1600.0, np.diag([1.0, -1, -1]), np.array([300.0, 320]))
    right = stretching(frontal.project(templates.neutral[ids]), frontal.project(stretched[0][ids]))
    given = Face(tools.morphable.template.with_vertices(stretched[0]), frontal)
    normal, neutral, moves, landmarks = [], [], [], []
    for landmark_map in (right, same):
        made = build_blendshapes(given, replace(tools, landmark_map=landmark_map))
        normal.append(
            np.linalg.norm(made.normal[0] - templates.neutral, axis=1).mean() / np.ptp(templates.neutral[:, 1])
        )
        own = errors(made, stretched)
        neutral.append(own[0])
        moves.append(own[1:].mean())
        landmarks.append(made.landmarks)
    assert normal[0] < 0.5 * normal[1]
    # A stretched face is taken for one with an expression, which is then undone.
    assert neutral[0] < 1e-9 and neutral[1] > 0.002
    assert moves[0] < 0.97 * moves[1]
    # A chin falls less in a face that is flatter than its normal one.
    falls = [(points[2] - points[0])[8, 1] for points in landmarks]
    assert falls[0] < 0.9 * falls[1]


def test_landmarks_keep_what_the_caricature_adds_to_the_normal_face(caricature, face, tools, same, built):
    made = build_blendshapes(face(caricature[0]), replace(tools, landmark_map=same), BlendshapeSettings("initial"))
    usual = built["initial"].fit.face.landmarks
    assert np.linalg.norm(made.fit.face.landmarks - usual, axis=1).mean() > 1, "the map tells which face is fitted"
    moved = made.fit.face.camera.project(made.normal[2][made.fit.anchors[:COUNT]])
    start = made.fit.face.camera.project(made.normal[0][made.fit.anchors[:COUNT]])
    np.testing.assert_allclose(made.landmarks[2] - made.landmarks[0], moved - start, atol=0.1)
    chin = made.landmarks[2, 8] - made.landmarks[0, 8]
    assert chin[1] > 10
    assert built["transfer"].landmarks is None


def test_a_model_of_latents_can_follow_the_landmarks(caricature, face, tools):
    made = build_blendshapes(face(caricature[0]), tools, BlendshapeSettings("initial", "latent"))
    jaw = int(tools.morphable.template.annotation.landmarks[8])
    assert made.shapes[2, jaw, 1] < caricature[0, jaw, 1] - 0.003
    assert np.isfinite(made.shapes).all() and np.abs(made.shapes[0] - caricature[0]).max() < 0.01


def test_a_triangle_without_area_is_refused(caricature, face, tools):
    flat = caricature[0].copy()
    flat[tools.templates.faces[9, 0]] = flat[tools.templates.faces[9, 1]]
    for method in ("full", "transfer"):
        with pytest.raises(NumericsError):
            build_blendshapes(face(flat), tools, BlendshapeSettings(method))


def test_a_face_that_no_picture_shows_is_refused(caricature, face, tools):
    with pytest.raises(InputError, match="expected a face with the camera"):
        build_blendshapes(face(caricature[0], None), tools)
    with pytest.raises(InputError, match="expected a model whose latent"):
        build_blendshapes(face(caricature[0]), replace(tools, latent=None), BlendshapeSettings("initial", "latent"))
