import numpy as np
import pytest
import torch

from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.models.deformable.config import NetworkSize
from caricli.models.deformable.model import DeformableModel, HyperSiren
from caricli.models.prior import Prior
from caricli.structures import Face
from caricli.template.fine_mesh import fine_mesh


@pytest.fixture(scope="module")
def deformable(head, head_template):
    """A network of random weights: smooth, and far from linear between vertices."""
    network = HyperSiren(NetworkSize(4, 16, 3, 8), torch.Generator().manual_seed(0))
    return DeformableModel(head_template, network, head.open_mouth_template().vertices, Prior.standard(4))


def face_of(vertices, model, latent=None):
    return Face(model.template.with_vertices(vertices), latent=latent, model_id=model.model_id)


@pytest.mark.parametrize("kind", ["pca", "intrinsic", "deformable"])
@pytest.mark.parametrize("levels", [0, 1, 3])
def test_the_faces_own_vertices_come_first(request, strangers, kind, levels):
    model, vertices = request.getfixturevalue(kind), strangers[1]
    fine = fine_mesh(model.template, levels)
    face = encode_face(face_of(vertices, model, 0.1 * model.prior.factor[0]), model)
    finer = subdivide_face(face, model, fine)
    assert finer.mesh.vertices.shape == (fine.weights.shape[0], 3)
    assert finer.mesh.polygons is fine.mesh.polygons and finer.levels == levels
    assert np.abs(finer.mesh.vertices[: len(vertices)] - vertices).max() < 1e-6


@pytest.mark.parametrize("kind", ["pca", "intrinsic"])
def test_linear_models_keep_their_surface(request, strangers, kind):
    model = request.getfixturevalue(kind)
    fine = fine_mesh(model.template, 2)
    for latent in (model.encode(strangers[0]), None):
        finer = subdivide_face(face_of(strangers[0], model, latent), model, fine)
        assert np.abs(finer.mesh.vertices - fine.weights @ strangers[0]).max() < 1e-9


def test_a_network_is_evaluated_between_its_vertices(deformable):
    latent = np.full(4, 0.3)
    fine = fine_mesh(deformable.template, 1)
    own = deformable.decode(latent)
    finer = subdivide_face(face_of(own, deformable, latent), deformable, fine).mesh.vertices
    expected = deformable.decode_at(latent, fine.weights @ deformable.box.points)
    assert np.abs(finer - expected).max() < 1e-6
    assert np.abs(finer - fine.weights @ own).max() > 1e-5
