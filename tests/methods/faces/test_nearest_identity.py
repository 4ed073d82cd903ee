import numpy as np
import pytest

from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.nearest_identity import likeness, nearest_identity
from caricli.structures import Face


def test_the_nearest_neutral_is_found():
    neutrals = np.random.default_rng(0).normal(size=(7, 5))
    owners = np.array([3, 0, 6, 3])
    assert nearest_identity(neutrals[owners] + 0.01, neutrals).tolist() == owners.tolist()
    # Not the direction counts but the place.
    assert nearest_identity(np.array([[4.0, 0.0]]), np.array([[1.0, 0.0], [4.0, 2.0]])).tolist() == [1]


def test_a_face_is_like_itself_until_another_is_nearer(pca, strangers):
    faces = [encode_face(Face(pca.template.with_vertices(vertices)), pca) for vertices in strangers[:3]]
    others = pca.prior.whiten(np.array([face.latent for face in faces[1:]]))
    same = likeness(faces[0], faces[0], pca, others)
    assert same.own == 0 and same.kept and same.people == 2
    assert same.nearest_other == pytest.approx(np.linalg.norm(others - pca.prior.whiten(faces[0].latent), axis=1).min())
    turned = likeness(faces[0], faces[2], pca, others)
    assert not turned.kept and turned.nearest_other == pytest.approx(0, abs=1e-9)
    assert likeness(faces[0], faces[1], pca, others[:0]) is None
