import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.geometry.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.head_rotation import head_rotation
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.measure_blendshapes import measure_blendshapes
from caricli.methods.rig.expression_templates import combined_templates, mended_templates
from caricli.methods.rig.measure_rig import curve_gap
from caricli.models.landmark_map.model import DOMAINS, GENERATOR_WEIGHTS, Domain, LandmarkMap
from caricli.structures.landmarks import COUNT
from caricli.store.models import load_model
from caricli.structures import Camera

EXPRESSIONS = {
    "neutral": {},
    "smile": {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8},
    "open": {"jawOpen": 0.8},
    "blink": {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
    "brows": {"browInnerUp": 1.0, "browOuterUpLeft": 1.0, "browOuterUpRight": 1.0},
}


@pytest.fixture(scope="module")
def templates(head, head_template):
    return combined_templates(mended_templates(head, head_template), EXPRESSIONS)


@pytest.fixture(scope="module")
def morphable():
    return load_model(kind="morphable")


@pytest.fixture(scope="module")
def same():
    """A landmark map that changes nothing."""
    size = 2 * COUNT
    domain = Domain(np.zeros(size), np.eye(size))
    none = {"linear": np.eye(size), "first": np.zeros((size, 1)), "first_bias": np.zeros(1), "second": np.zeros((1, 1)),
            "second_bias": np.zeros(1), "last": np.zeros((1, size)), "last_bias": np.zeros(size)}  # fmt: skip
    assert set(none) == set(GENERATOR_WEIGHTS)
    return LandmarkMap(dict.fromkeys(DOMAINS, domain), dict.fromkeys(DOMAINS, none))


@pytest.fixture(scope="module")
def caricature(templates):
    """(K, V, 3) an exaggerated face with every expression."""
    shapes = (templates.neutral + templates.deltas) * [1.15, 0.9, 1.2]
    return np.stack([exaggerate_curvature(shape, templates.faces, [0.2])[0] for shape in shapes])


@pytest.fixture(scope="module")
def pose():
    return Camera(1600.0, head_rotation(np.radians([4.0, 12, -3])), np.array([300.0, 320]))


@pytest.fixture(scope="module")
def built(caricature, pose, templates, morphable, same):
    """Blendshapes of the caricature, seen neutral, by method."""
    known = caricature[0], pose, templates, morphable, same
    return {method: build_blendshapes(*known, method) for method in ("full", "initial", "transfer")}


def errors(made, truth):
    return np.linalg.norm(made.shapes - truth, axis=2).mean(1) / np.ptp(truth[0, :, 1])


def test_every_method_comes_nearer_to_the_truth_than_a_face_that_keeps_still(built, caricature):
    still = np.linalg.norm(caricature - caricature[0], axis=2).mean(1) / np.ptp(caricature[0, :, 1])
    for name, made in built.items():
        assert errors(made, caricature)[1:].mean() < (1.0 if name == "initial" else 0.85) * still[1:].mean(), name
        assert errors(made, caricature)[0] < 0.006, name


def test_optimised_shapes_drift_less_and_show_no_less(built, caricature):
    found = {
        name: measure_blendshapes(made.shapes - caricature[0], made.normal - made.normal_given)
        for name, made in built.items()
    }
    drift = {name: np.nanmean(each.drift) for name, each in found.items()}
    assert drift["full"] < 0.5 * min(drift["initial"], drift["transfer"])
    assert 0.8 < np.nanmin(found["full"].strength) and np.nanmax(found["full"].strength) < 1.4
    assert errors(built["full"], caricature).mean() < errors(built["initial"], caricature).mean()


def test_lids_meet_where_contacts_are_kept(built, caricature, pose, templates, morphable, same, head_template):
    free = build_blendshapes(caricature[0], pose, templates, morphable, same, contacts=False)
    blink, note = templates.names.index("blink"), head_template.annotation
    for side in ("left", "right"):
        ids = [note.curves[f"eye_{lid}_{side}"] for lid in ("upper", "lower")]
        usual = curve_gap(caricature[0], *ids)
        assert curve_gap(built["full"].shapes[blink], *ids) < 0.03 * usual < curve_gap(free.shapes[blink], *ids)


def test_lips_close_on_an_open_jaw(head, head_template, caricature, pose, morphable, same):
    both = {"neutral": {}, "mouthClose": {"mouthClose": 1.0}, "jawOpen": {"jawOpen": 1.0}}
    made = build_blendshapes(
        caricature[0], pose, combined_templates(mended_templates(head, head_template), both), morphable, same
    )
    ids = [head_template.annotation.curves[f"mouth_inner_{lip}"] for lip in ("upper", "lower")]
    neutral, close, wide = made.shapes
    assert curve_gap((wide + close - neutral)[:, :2], *ids) < 0.2 * curve_gap(wide[:, :2], *ids)


def test_an_expression_in_the_picture_is_undone(caricature, pose, templates, morphable, same):
    wide = templates.names.index("open")
    made = build_blendshapes(caricature[wide], pose, templates, morphable, same)
    chin, away = morphable.template.annotation.landmarks[5:12], np.linalg.norm(caricature[wide] - caricature[0], axis=1)
    left = np.linalg.norm(made.shapes[0] - caricature[0], axis=1)
    assert left[chin].mean() < 0.7 * away[chin].mean()
    assert np.linalg.norm(made.shapes[wide] - caricature[wide], axis=1).mean() < 0.5 * away.mean()


@pytest.mark.parametrize("method", ["full", "initial", "transfer"])
def test_the_size_of_the_face_does_not_matter(built, caricature, pose, templates, morphable, same, method):
    smaller = Camera(pose.scale / 3, pose.rotation, pose.translation)
    made = build_blendshapes(3 * caricature[0], smaller, templates, morphable, same, method)
    np.testing.assert_allclose(made.shapes, 3 * built[method].shapes, atol=1e-6)


def test_landmarks_are_carried_by_the_map(built, caricature, pose):
    made = built["initial"]
    moved = made.fit.face.camera.project(made.normal[2][made.fit.anchors[:COUNT]])
    start = made.fit.face.camera.project(made.normal[0][made.fit.anchors[:COUNT]])
    np.testing.assert_allclose(made.landmarks[2] - made.landmarks[0], moved - start, atol=0.1)
    chin = made.landmarks[2, 8] - made.landmarks[0, 8]
    assert chin[1] > 10
    assert built["transfer"].landmarks is None


def test_a_model_of_latents_can_follow_the_landmarks(caricature, pose, templates, morphable, same):
    made = build_blendshapes(caricature[0], pose, templates, morphable, same, "initial", model=load_model(kind="pca"))
    jaw = int(morphable.template.annotation.landmarks[8])
    assert made.shapes[2, jaw, 1] < caricature[0, jaw, 1] - 0.003
    assert np.isfinite(made.shapes).all() and np.abs(made.shapes[0] - caricature[0]).max() < 0.01


def test_a_triangle_without_area_is_refused(caricature, pose, templates, morphable, same):
    flat = caricature[0].copy()
    flat[templates.faces[9, 0]] = flat[templates.faces[9, 1]]
    for method in ("full", "transfer"):
        with pytest.raises(NumericsError):
            build_blendshapes(flat, pose, templates, morphable, same, method)
