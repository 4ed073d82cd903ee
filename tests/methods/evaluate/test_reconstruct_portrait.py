from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.methods.evaluate.reconstruct_portrait import (
    ADJUSTED,
    COARSE,
    METHODS,
    PAPER_SIDE,
    REFINED,
    Reconstruction,
    measure_portrait,
    reconstruct_portrait,
)
from caricli.structures import Face
from tests.methods.evaluate.conftest import SIZE


@pytest.fixture(scope="module")
def models(head_template):
    from caricli.store.portraits import load_rivals

    return load_rivals(head_template)


def test_refining_beats_every_rival_at_the_landmarks(portrait, models):
    fits, refused = reconstruct_portrait(portrait, models)
    assert tuple(fits) == METHODS and not refused
    for name in COARSE:
        # The elastic fit may be as near as that by itself.
        assert fits[name + REFINED].errors["all"] < max(0.1, fits[name].errors["all"] / 5)
        assert fits[name + REFINED].seconds > fits[name].seconds
        for key in (name, name + REFINED):
            face = fits[key].face
            projected = face.camera.project(face.vertices)
            nearest = np.linalg.norm(projected[:, None] - face.landmarks, axis=2).min(0)
            assert nearest.max() < 1e-6
    exp, both = (fits[name].errors["all"] for name in ADJUSTED)
    # Adjusting more coefficients, and with less regularisation, comes nearer, but not as near.
    assert fits["morphable" + REFINED].errors["all"] < both < exp
    assert both < fits["morphable"].errors["all"]


def test_a_refinement_that_is_refused_leaves_the_others(portrait, models, monkeypatch):
    monkeypatch.setattr("caricli.methods.evaluate.reconstruct_portrait.COARSE", {"morphable": COARSE["morphable"]})
    points = portrait.points.copy()
    middle = points[48:68].mean(0)
    points[[61, 62, 63, 65, 66, 67]] = 2 * middle - points[[61, 62, 63, 65, 66, 67]] + [0, 3]
    points[[61, 62, 63]] += [0, 0.1 * SIZE]
    fits, refused = reconstruct_portrait(replace(portrait, points=points), models)
    assert list(fits) == ["morphable", *ADJUSTED]
    assert list(refused) == ["morphable" + REFINED] and "crossed" in refused["morphable" + REFINED]


def test_3d_error_is_of_the_face_and_free_of_similarities(portrait, head_template):
    errors = {"eyes": 0.5, "all": 1.0}
    turn = rotation_matrices(np.radians([[10.0, 40, 5]]))[0]
    exact = 1.3 * portrait.truth @ turn.T + [0.1, 0.2, 0.3]
    face = np.isin(np.arange(len(exact)), head_template.region("face"))
    exact[~face] += 1.0
    face = Face(head_template.with_vertices(exact), portrait.camera, portrait.points)
    fit = Reconstruction(face, errors, 0.001, 2.0)
    figures = measure_portrait(fit, portrait, head_template)
    assert figures["shape"] < 1e-9 and figures["flipped"] == pytest.approx(0.1) and figures["seconds"] == 2.0
    bumpy = portrait.truth + 0.002 * np.where(np.arange(len(exact)) % 2, 1, -1)[:, None] * [0, 0, 1]
    bumpy_face = replace(face, mesh=head_template.with_vertices(bumpy))
    share = measure_portrait(replace(fit, face=bumpy_face), portrait, head_template)["shape"]
    assert share == pytest.approx(100 * 0.002 / np.ptp(portrait.truth[:, 1]), rel=0.05)
    assert "shape" not in measure_portrait(fit, replace(portrait, truth=None), head_template)


def test_pixels_are_summed_over_known_landmarks_in_a_picture_of_the_papers_size(portrait, head_template):
    points = portrait.points.copy()
    points[40] = np.nan
    face = Face(head_template.with_vertices(portrait.truth), portrait.camera)
    fit = Reconstruction(face, {"eyes": 2.0, "all": 1.0}, 0.0, 0.0)
    figures = measure_portrait(fit, replace(portrait, points=points), head_template)
    diagonal = np.linalg.norm(np.nanmax(points, axis=0) - np.nanmin(points, axis=0)) * PAPER_SIDE / SIZE
    assert figures["pixels"] == pytest.approx({"eyes": 11 * 0.02 * diagonal, "all": 67 * 0.01 * diagonal})
