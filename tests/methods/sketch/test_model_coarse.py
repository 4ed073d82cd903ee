import numpy as np
import pytest

from caricli.methods.faces.encode_landmarks import landmark_encoder
from caricli.methods.sketch.fit_lines import fit_lines
from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.methods.sketch.model_coarse import model_coarse
from caricli.store.models import load_model


@pytest.fixture(scope="module")
def encoder(model):
    return landmark_encoder(model, load_model())


def test_a_face_that_the_model_has_stays_inside(encoder, model, handles, camera, sketch):
    vertices = model.decode(model.prior.mean)
    own = camera.project(vertices)
    lines = {curve.name: [own[curve.vertices]] for curve in handles.curves}
    face, name = model_coarse(sketch, lines, handles, encoder)
    np.testing.assert_array_equal(face.vertices, fit_lines(lines, handles, model).vertices)
    assert name == "model"


def test_a_drawing_far_from_all_faces_is_met_by_an_elastic_one(encoder, model, handles, sketch):
    """The nose is drawn half as long again, the jaw twice as far below the mouth on one side."""

    def bent(line):
        x, y = (line - 128).T
        return 128 + np.column_stack([x + 0.004 * x * y, y + 0.006 * x * np.maximum(y, 0)])

    lines = {name: [bent(line) for line in several] for name, several in lines_by_curve(sketch).items()}
    errors = []
    coarse, name = model_coarse(sketch, lines, handles, encoder)
    for face in (coarse, fit_lines(lines, handles, model)):
        own = face.require_camera().project(face.vertices[handles.vertices])
        gaps = np.linalg.norm(handles.places(lines, own) - own, axis=1)
        errors.append(np.nanmean(gaps[handles.rows_of("mouth")]))
    assert errors[0] < 0.6 * errors[1]
    assert coarse.model_id == model.model_id and name == "elastic"
