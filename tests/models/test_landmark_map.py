from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.models.landmark_map.model import (
    DOMAINS,
    LandmarkMap,
    align,
    map_from_checkpoint,
    map_to_checkpoint,
    place,
)

STYLES = 4


@pytest.fixture
def generator():
    return np.random.default_rng(0)


@pytest.fixture
def landmark_map(generator):
    """Random, with four styles at right angles."""
    styles = np.linalg.qr(generator.normal(size=(136, STYLES)))[0].T * np.linspace(2, 1, STYLES)[:, None]
    normal, caricature = generator.normal(size=(2, 136))
    return LandmarkMap(normal, caricature, generator.normal(size=(136, 136)), styles)


def turned(points):
    """The same face elsewhere, turned and larger."""
    turn = 30 * np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    return points @ turn + [200.0, -40.0]


def test_aligned_landmarks_do_not_depend_on_place_size_and_turn(generator):
    faces = generator.normal(size=(3, 68, 2))
    np.testing.assert_allclose(align(turned(faces))[0], align(faces)[0], atol=1e-12)


def test_aligned_eyes_and_mouth_of_a_face_that_fits_lie_where_they_should(generator):
    face = generator.normal(size=(68, 2))
    for part, where in ((slice(36, 42), [-0.5, 0]), (slice(42, 48), [0.5, 0]), (slice(48, 68), [0, 1])):
        face[part] += where - face[part].mean(0)
    np.testing.assert_allclose(align(turned(face))[0], face, atol=1e-12)


def test_place_undoes_align(generator):
    faces = 100 * generator.normal(size=(3, 68, 2))
    np.testing.assert_allclose(place(*align(faces)), faces, atol=1e-9)


def test_a_face_in_one_place_is_refused(generator):
    face = generator.normal(size=(68, 2))
    face[36:] = 3.0
    with pytest.raises(InputError, match="eyes and mouth"):
        align(face)


def test_a_caricature_is_the_face_and_what_its_style_adds(landmark_map, generator):
    face = generator.normal(size=(5, 68, 2))
    shift = (landmark_map.caricature - landmark_map.normal).reshape(68, 2)
    likeliest = landmark_map.map_aligned(face, "caricature")
    np.testing.assert_allclose(likeliest, face + shift)
    styles = landmark_map.draw_styles(generator, 5)
    assert styles.shape == (5, STYLES) and 0.3 < styles.std() < 2
    added = (landmark_map.map_aligned(face, "caricature", styles) - likeliest).reshape(5, 136)
    np.testing.assert_allclose(added, styles @ landmark_map.styles, atol=1e-12)


def test_what_changes_a_caricature_changes_its_normal_face(landmark_map, generator):
    one, other = generator.normal(size=(2, 68, 2))
    apart = landmark_map.map_aligned(one, "normal") - landmark_map.map_aligned(other, "normal")
    np.testing.assert_allclose(apart.ravel(), (one - other).ravel() @ landmark_map.to_normal, atol=1e-12)
    mean = landmark_map.caricature.reshape(68, 2)
    np.testing.assert_allclose(landmark_map.map_aligned(mean, "normal").ravel(), landmark_map.normal, atol=1e-12)


def test_the_own_style_makes_more_of_what_is_unusual(landmark_map):
    landmark_map = replace(landmark_map, normal=align(landmark_map.normal.reshape(68, 2))[0].ravel())
    face = align((landmark_map.normal + 0.1 * landmark_map.styles[2]).reshape(68, 2))[0]
    style = landmark_map.own_style(face)
    assert np.linalg.norm(style) == pytest.approx(STYLES**0.5)
    assert np.abs(style).argmax() == 2 and style[2] > 0
    np.testing.assert_allclose(landmark_map.own_style(turned(face)), style, atol=1e-9)
    unusual = face.ravel() - landmark_map.normal
    assert unusual @ (style @ landmark_map.styles) > 0
    # Of two at once as much as there is of each, however strong styles are.
    both = align((landmark_map.normal + 0.1 * landmark_map.styles.T @ [0, 3, 0, -1]).reshape(68, 2))[0]
    assert landmark_map.own_style(both)[3] / landmark_map.own_style(both)[1] == pytest.approx(-1 / 3, abs=0.1)
    usual = landmark_map.own_style(landmark_map.normal.reshape(68, 2))
    assert np.isfinite(usual).all()


def test_a_map_commutes_with_similarities(landmark_map, generator):
    face = generator.normal(size=(68, 2))
    for name, style in (("normal", None), ("caricature", None), ("caricature", np.ones(STYLES))):
        mapped = landmark_map.map(turned(face), name, style)
        np.testing.assert_allclose(mapped, turned(landmark_map.map(face, name, style)), rtol=1e-9)


def test_a_checkpoint_rebuilds_the_map(landmark_map, generator):
    tensors, metadata = map_to_checkpoint(landmark_map, {"seed": 1})
    found, face = map_from_checkpoint(tensors, metadata, "m"), generator.normal(size=(68, 2))
    assert metadata["recipe"] == {"seed": 1}
    for name in DOMAINS:
        np.testing.assert_allclose(found.map(face, name), landmark_map.map(face, name), rtol=1e-4)
    np.testing.assert_allclose(found.styles, landmark_map.styles, rtol=1e-6)


def test_checkpoints_that_are_no_map_are_refused(landmark_map):
    tensors, metadata = map_to_checkpoint(landmark_map, {})
    damaged = (
        ("schema", tensors, metadata | {"schema": "caricli.landmark-map/1"}),
        ("scheme 'ibug68', found 'wflw98'", tensors, metadata | {"scheme": "wflw98"}),
        ("normal", {k: v for k, v in tensors.items() if k != "normal"}, metadata),
        ("styles", {k: v for k, v in tensors.items() if k != "styles"}, metadata),
        ("styles", tensors | {"styles": np.zeros((), np.float32)}, metadata),
        ("found none", tensors | {"styles": np.zeros((0, 136), np.float32)}, metadata),
        ("normal", tensors | {"normal": np.zeros(98, np.float32)}, metadata),
        ("to_normal", tensors | {"to_normal": np.zeros((2, 2), np.float32)}, metadata),
        ("floating point", tensors | {"to_normal": np.zeros((136, 136), np.int32)}, metadata),
        ("changes nothing", tensors | {"styles": np.zeros((5, 136), np.float32)}, metadata),
    )
    for message, *checkpoint in damaged:
        with pytest.raises(InputError, match=message):
            map_from_checkpoint(*checkpoint, "m")
