import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.edit.caricaturize_face import _broad, caricature_figures, caricaturize_face, exaggeration
from caricli.methods.edit.handle_points import vertex_of
from caricli.methods.faces.encode_face import encode_face
from caricli.structures import Directions, Face
from caricli.template.annotation import DELICATE


def encoded(vertices, model):
    return encode_face(Face(model.template.with_vertices(vertices)), model)


@pytest.fixture(params=["pca", "kernel", "intrinsic"])
def model(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def directions(model):
    normal, one = np.random.default_rng(0).normal(size=(1, len(model.prior.mean))), np.ones(1)
    normal /= np.linalg.norm(normal)
    return Directions(("Caricature",), normal, 0 * normal, one, one, 1, one, one, "", {}, normal[:0])


def test_the_direction_is_measured_in_its_own_steps(model, directions, strangers):
    face = encoded(strangers[1], model)
    grown = [caricaturize_face(face, model, s, "direction", directions) for s in (0, 1, 2)]
    steps = np.diff([exaggeration(each, model, directions).caricature for each in grown])
    np.testing.assert_allclose(steps, 1, atol=1e-9)
    assert all(each.residual is face.residual for each in grown)
    np.testing.assert_allclose(grown[0].vertices, face.vertices, atol=1e-8)


def test_own_grows_in_step_and_nearly_without_flips(model, strangers):
    face = encoded(strangers[0], model)
    grown = [caricaturize_face(face, model, s, "own") for s in (0, 0.1, 0.6, 1.5, 2)]
    distances = [exaggeration(each, model).distance for each in grown]
    assert (np.diff(distances) > 0).all() and distances[-1] > 1.4 * distances[0]
    assert grown[0] is face and exaggeration(face, model).caricature is None
    assert max(flipped_triangles(each.vertices, model.template.gradients).mean() for each in grown) < 0.003


def test_own_enlarges_no_details(pca, strangers):
    """A wart on the forehead."""
    spot = vertex_of("forehead", pca.template)
    wart = 0.003 * (np.arange(len(strangers[0])) == spot)[:, None] * [0, 0, 1]
    plain, warty = (
        caricaturize_face(encoded(strangers[0] + more, pca), pca, 1.0, "own").vertices for more in (0 * wart, wart)
    )
    assert warty[spot, 2] - plain[spot, 2] == pytest.approx(0.003, abs=5e-4)


def test_own_leaves_nothing_of_the_mouth_before_the_skin(pca, strangers):
    grown = caricaturize_face(encoded(strangers[1], pca), pca, 2.0, "own").vertices
    np.testing.assert_allclose(pca.template.cavities.tuck(grown), grown, atol=1e-4)


def test_own_fades_out_over_several_edges(pca):
    """What is the same everywhere is left whole far from eyes and mouth, nowhere on them, and by steps between."""
    template = pca.template
    share = _broad(np.ones((len(template.vertices), 1)), template)[:, 0]
    edges = np.concatenate([template.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    assert share.min() == 0 and share.max() == pytest.approx(1)
    assert np.abs(share[edges[:, 0]] - share[edges[:, 1]]).max() < 0.6


def test_own_moves_and_turns_with_the_face(pca, strangers):
    turn = rotation_matrices(np.radians([[5.0, 10.0, -3.0]]))[0]
    face, turned = (encoded(v, pca) for v in (strangers[3], 1.1 * strangers[3] @ turn.T + 0.05))
    grown, other = (caricaturize_face(each, pca, 1.0, "own").vertices for each in (face, turned))
    assert np.abs(other - (1.1 * grown @ turn.T + 0.05)).max() < 1e-6
    assert exaggeration(turned, pca).distance == pytest.approx(exaggeration(face, pca).distance, abs=1e-9)


def test_own_changes_eyes_and_mouth_less_than_the_rest(pca, strangers):
    gradients, held = pca.template.gradients, pca.template.mask(*DELICATE)
    for vertices in strangers[:3]:
        face = encoded(vertices, pca)
        grown = caricaturize_face(face, pca, 1.0, "own")
        change = np.linalg.norm(gradients.features(grown.vertices) - gradients.features(face.vertices), axis=1)
        assert np.median(change[held]) < 0.7 * np.median(change[~held])


def test_a_thin_neck_does_not_become_a_thread(pca):
    template = pca.template
    heights = template.vertices[:, 1]
    low = template.mask("neck") & (heights < heights[template.annotation.landmarks[8]])
    thin = template.vertices.copy()
    thin[low] += 0.7 * (thin[low].mean(0) - thin[low]) * (1, 0, 1)
    grown = caricaturize_face(encoded(thin, pca), pca, 2.0, "own").vertices
    end = low & (heights < np.quantile(heights[low], 0.3))
    width, before = (np.ptp(each[end, 0]) for each in (grown, thin))
    assert width > 0.7 * before


def test_directions_without_caricatures_are_refused(pca, strangers):
    normal, one = np.eye(len(pca.prior.mean))[:1], np.ones(1)
    others = Directions(("Smile",), normal, normal, one, one, 1, one, one, "", {}, normal[:0])
    face = encoded(strangers[0], pca)
    assert exaggeration(face, pca, others).caricature is None
    with pytest.raises(InputError, match="'Caricature': not among the 1 known"):
        caricaturize_face(face, pca, 1.0, "direction", others)


def test_a_direction_needs_directions(pca, strangers):
    with pytest.raises(InputError, match="expected directions of the model"):
        caricaturize_face(encoded(strangers[0], pca), pca, 1.0)


def test_a_mode_of_no_such_name_is_refused(pca, strangers):
    with pytest.raises(InputError, match="expected a mode of direction, own, found 'owm'"):
        caricaturize_face(encoded(strangers[0], pca), pca, 1, "owm")


@pytest.mark.parametrize("strength", [-1.0, np.nan, np.inf])
def test_what_is_no_strength_is_refused(pca, strangers, strength):
    with pytest.raises(InputError, match=f"expected a strength of 0 or more, found {strength:g}"):
        caricaturize_face(encoded(strangers[0], pca), pca, strength, "own")


def test_figures_before_and_after(pca, strangers):
    before = encoded(strangers[0], pca)
    after = caricaturize_face(before, pca, 1.0, "own")
    figures = caricature_figures(before, after, pca)
    assert list(figures) == ["before", "after"]
    for when, face in (("before", before), ("after", after)):
        assert figures[when]["exaggeration"] == {"distance": exaggeration(face, pca).distance}
        assert figures[when]["prior_rms"] == face.prior_rms and "BigNose" in figures[when]["attributes"]
