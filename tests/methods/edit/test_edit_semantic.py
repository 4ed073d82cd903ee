from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic, label_direction
from caricli.methods.faces.encode_face import decode_face, encode_face
from caricli.models.prior import Prior
from caricli.structures import Directions, Face


def directions_of(normals, gradients=None):
    normals = np.asarray(normals, float)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    zeros = np.zeros(len(normals))
    names = ("BigNose", "Smile", "Old")[: len(normals)]
    gradients = np.zeros_like(normals) if gradients is None else np.asarray(gradients, float)
    return Directions(names, normals, gradients, zeros, zeros, 1, zeros, zeros, "", {}, normals[:0])


def encoded(vertices, model):
    return encode_face(Face(model.template.with_vertices(vertices)), model)


@pytest.fixture(params=["pca", "intrinsic", "kernel"])
def model(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def directions(model):
    generator = np.random.default_rng(0)
    normals, gradients = generator.normal(size=(2, 3, len(model.prior.mean)))
    return directions_of(normals, gradients)


def test_the_whitened_latent_moves_by_the_strengths(model, directions, strangers):
    face = encoded(strangers[1], model)
    edited = edit_semantic(face, model, SemanticEdit(directions, {"BigNose": 2.0, "Old": -1.0}))
    step = model.prior.whiten(edited.latent) - model.prior.whiten(face.latent)
    np.testing.assert_allclose(step, 2 * directions.normals[0] - directions.normals[2], atol=1e-9)
    assert edited.residual is face.residual
    assert np.abs(edited.vertices - face.vertices).max() > 1e-3


def test_steps_are_standard_deviations_of_any_prior(pca, strangers):
    count = len(pca.prior.mean)
    wide = copy(pca)
    wide.prior = Prior(pca.prior.mean, 2 * np.eye(count) + np.eye(count, k=-1))
    known = directions_of(np.random.default_rng(0).normal(size=(3, count)))
    face = encoded(strangers[1], wide)
    edited = edit_semantic(face, wide, SemanticEdit(known, {"Old": 1.5}))
    step = wide.prior.whiten(edited.latent) - wide.prior.whiten(face.latent)
    np.testing.assert_allclose(step, 1.5 * known.normals[2], atol=1e-9)


def test_there_and_back_is_the_same_face(model, directions, strangers):
    face = encoded(model.template.mended(strangers[3]) + 0.02, model)
    edit = SemanticEdit(directions, {"Smile": 3.0}, ["Old"])
    there = edit_semantic(face, model, edit)
    back = edit_semantic(there, model, edit.scaled(-1))
    assert np.abs(back.vertices - face.vertices).max() < 1e-7 * model.template.height
    zero = edit_semantic(face, model, edit.scaled(0))
    assert np.abs(zero.vertices - face.vertices).max() < 1e-8


def test_far_edits_are_mended_and_lead_back(model, directions, strangers):
    face = encoded(model.template.mended(strangers[3]), model)
    edit = SemanticEdit(directions, {"Smile": 12.0})
    there = edit_semantic(face, model, edit)
    gradients = model.template.gradients
    torn, mended = (flipped_triangles(each.vertices, gradients).sum() for each in (decode_face(there, model), there))
    assert mended < torn / 4
    anew = encode_face(Face(there.mesh, latent=there.latent, residual=there.residual, model_id=there.model_id), model)
    assert anew.residual is there.residual
    for edited in (there, anew):
        back = edit_semantic(edited, model, edit.scaled(-1))
        assert np.abs(back.vertices - face.vertices).max() < 1e-7 * model.template.height


def test_a_torn_face_comes_back_mended(pca, directions, strangers):
    face = encoded(strangers[2], pca)
    mended = pca.template.mended(face.vertices)
    assert np.abs(mended - face.vertices).max() > 1e-3
    edit = SemanticEdit(directions, {"Smile": 0.1})
    back = edit_semantic(edit_semantic(face, pca, edit), pca, edit.scaled(-1))
    assert np.abs(back.vertices - mended).max() < 1e-7


def test_nothing_of_another_model_is_edited(pca, kernel, directions, strangers):
    face = encoded(strangers[1], pca)
    bare: Any = Face(face.mesh, latent=face.latent, model_id=pca.model_id)
    edit = SemanticEdit(directions, {"Smile": 1.0})
    with pytest.raises(InputError, match="gave for this model, found one of another"):
        edit_semantic(face, kernel, edit)
    with pytest.raises(InputError, match="found one that was not encoded"):
        edit_semantic(bare, pca, edit)
    foreign = SemanticEdit(replace(directions, model_id=kernel.model_id), {"Smile": 1.0})
    with pytest.raises(InputError, match="directions in the latents of this model, found those of another"):
        edit_semantic(face, pca, foreign)


def test_what_is_kept_is_not_in_the_direction():
    known = directions_of([[1, 1, 0, 0], [0, 1, 0, 1], [0, 0, 1, 0]], [[0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])
    free = label_direction(known, "BigNose", ["Smile"])
    assert np.isclose(np.linalg.norm(free), 1) and free @ known.normals[0] > 0
    assert abs(free @ known.normals[1]) < 1e-12 and abs(free @ known.gradients[1]) < 1e-12
    assert label_direction(known, "BigNose") is not free
    np.testing.assert_allclose(label_direction(known, "BigNose", ["Old"]), known.normals[0])


def test_a_label_cannot_change_while_its_opposite_is_kept():
    known = directions_of([[1, 0.01, 0], [-1, 0, 0]])
    with pytest.raises(InputError, match="BigNose: cannot change while Smile is kept"):
        label_direction(known, "BigNose", ["Smile"])


def test_the_nearest_name_is_suggested():
    known = directions_of(np.eye(3))
    for name, near in (("bignose", "BigNose"), ("Smlie", "Smile"), ("Elderly", "")):
        with pytest.raises(InputError, match=f"{name}.*3 known.*did you mean '{near}"):
            label_direction(known, name)


@pytest.mark.parametrize("strength", [np.nan, np.inf, 21.0, -1e9])
def test_absurd_strengths_are_refused(pca, strength):
    known = directions_of(np.eye(len(pca.prior.mean))[:3])
    with pytest.raises(InputError, match="Smile: expected a strength of at most 20"):
        SemanticEdit(known, {"Smile": strength})
