import numpy as np
import pytest

from caricli.errors import InputError
from caricli.models.landmark_map.model import (
    DOMAINS,
    GENERATOR_WEIGHTS,
    Domain,
    LandmarkMap,
    align,
    generate,
    generator_shapes,
    map_from_checkpoint,
    map_to_checkpoint,
    other,
    place,
)

WIDTH = 6


@pytest.fixture
def generator():
    return np.random.default_rng(0)


@pytest.fixture
def landmark_map(generator):
    """Of 5 components for normal faces and 4 for caricatures, with random weights."""
    sizes = dict(zip(DOMAINS, (5, 4), strict=True))
    domains = {}
    for name, size in sizes.items():
        basis = np.linalg.qr(generator.normal(size=(136, size)))[0].T * np.linspace(2, 1, size)[:, None]
        domains[name] = Domain(generator.normal(size=136), basis)
    networks = {}
    for name in DOMAINS:
        shapes = generator_shapes(sizes[other(name)], WIDTH, sizes[name])
        assert tuple(shapes) == GENERATOR_WEIGHTS
        networks[name] = {key: generator.normal(size=shape) for key, shape in shapes.items()}
    return LandmarkMap(domains, networks)


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


def test_codes_are_those_that_were_decoded(landmark_map, generator):
    for domain in landmark_map.domains.values():
        codes = generator.normal(size=(3, len(domain.basis)))
        np.testing.assert_allclose(domain.encode(domain.decode(codes)), codes, atol=1e-10)


def test_the_network_is_the_same_for_arrays_and_tensors(landmark_map, generator):
    import torch

    weights, codes = landmark_map.generators["normal"], generator.normal(size=(7, 4))
    found = generate({name: torch.from_numpy(value) for name, value in weights.items()}, torch.from_numpy(codes))
    np.testing.assert_allclose(found.numpy(), generate(weights, codes), atol=1e-12)


def test_a_map_commutes_with_similarities(landmark_map, generator):
    face = generator.normal(size=(68, 2))
    for name in DOMAINS:
        np.testing.assert_allclose(
            landmark_map.map(turned(face), name), turned(landmark_map.map(face, name)), rtol=1e-9
        )


def test_a_checkpoint_rebuilds_the_map(landmark_map, generator):
    tensors, metadata = map_to_checkpoint(landmark_map, {"seed": 1})
    found, face = map_from_checkpoint(tensors, metadata, "m"), generator.normal(size=(68, 2))
    assert metadata["recipe"] == {"seed": 1}
    for name in DOMAINS:
        np.testing.assert_allclose(found.map(face, name), landmark_map.map(face, name), rtol=1e-4)


def test_checkpoints_that_are_no_map_are_refused(landmark_map):
    tensors, metadata = map_to_checkpoint(landmark_map, {})
    damaged = (
        ("schema", tensors, metadata | {"schema": "caricli.model/1"}),
        ("scheme 'ibug68', found 'wflw98'", tensors, metadata | {"scheme": "wflw98"}),
        ("normal.mean", {k: v for k, v in tensors.items() if k != "normal.mean"}, metadata),
        ("to_normal.linear", tensors | {"normal.basis": np.zeros((0, 136), np.float32)}, metadata),
        ("normal.mean", tensors | {"normal.mean": np.zeros(98, np.float32)}, metadata),
        ("to_normal.second", tensors | {"to_normal.second": np.zeros((2, 2), np.float32)}, metadata),
        ("floating point", tensors | {"to_normal.linear": np.zeros((4, 5), np.int32)}, metadata),
        ("length zero", tensors | {"normal.basis": np.zeros((5, 136), np.float32)}, metadata),
    )
    for message, *checkpoint in damaged:
        with pytest.raises(InputError, match=message):
            map_from_checkpoint(*checkpoint, "m")
