"""Pieces of a head beside its skin."""

from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Face, Hair, Material, Mesh, Part

SKIN = Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]),
    np.array([[0, 1, 3, 2]]),
    np.eye(4, 2),
    np.array([[0, 1, 2, 3]]),
)
SHELL = Mesh(np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]), np.array([[0, 1, 2]]), np.eye(3, 2), np.array([[0, 1, 2]]))
HAIR = Hair(SHELL, np.array([[0, 1, 2], [1, 1, 1], [2, 3, 0]]), np.array([[0.5, 0.5, 0], [1, 0, 0], [0.2, 0.8, 0]]))
PART = Part("teeth", SHELL, np.array([Material.TEETH]), "jaw", ("jawOpen",), np.zeros((1, 3, 3)))


def test_hair_follows_the_skin():
    face = Face(SKIN, hair=HAIR)
    moved = face.posed(SKIN.vertices + [1, 2, 3])
    np.testing.assert_allclose(moved.hair.shell.vertices, SHELL.vertices + [1, 2, 3])
    stretched = face.posed(SKIN.vertices * 2)
    shift = HAIR.footing(SKIN.vertices)
    np.testing.assert_allclose(stretched.hair.shell.vertices, SHELL.vertices + shift)
    np.testing.assert_array_equal(face.hair.shell.vertices, SHELL.vertices)


def test_a_face_takes_the_hair_of_another_along():
    bald = Face(SKIN.with_vertices(SKIN.vertices * 2), latent=np.ones(3))
    worn = bald.wearing(Face(SKIN, hair=HAIR))
    np.testing.assert_allclose(worn.hair.shell.vertices, SHELL.vertices + HAIR.footing(SKIN.vertices))
    np.testing.assert_array_equal(worn.vertices, bald.vertices)
    assert worn.latent is bald.latent
    assert worn.without_latent().hair is worn.hair


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"roots": HAIR.roots[:2]}, "hair_roots: expected (3, 3)"),
        ({"roots": HAIR.roots.astype(float)}, "hair_roots: expected (3, 3)"),
        ({"roots": -HAIR.roots}, "hair_roots: expected (3, 3)"),
        ({"weights": HAIR.weights[:, :2]}, "hair_weights: expected the shape (3,3)"),
        ({"weights": HAIR.weights * np.nan}, "hair_weights: expected finite"),
        ({"shell": Mesh(SHELL.vertices, SHELL.polygons)}, "hair_uvs: expected a place"),
    ],
)
def test_hair_that_does_not_fit_is_refused(change, words):
    with pytest.raises(InputError) as refused:
        replace(HAIR, **change)
    assert words in str(refused.value)


def test_hair_needs_the_skin_that_it_stands_on():
    with pytest.raises(InputError, match="hair_roots: expected vertices below 4, found 9"):
        Face(SKIN, hair=replace(HAIR, roots=HAIR.roots + 6))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"hangs_on": "nose"}, "teeth: expected it to hang on skull, jaw"),
        ({"deltas": np.zeros((2, 3, 3))}, "teeth: expected deltas of the shape (1, 3, 3)"),
        ({"deltas": np.full((1, 3, 3), np.inf)}, "teeth: expected finite"),
        ({"materials": np.array([99])}, "materials: expected"),
    ],
)
def test_a_part_that_does_not_fit_is_refused(change, words):
    with pytest.raises(InputError) as refused:
        replace(PART, **change)
    assert words in str(refused.value)
