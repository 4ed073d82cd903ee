from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.geometry.lines.along_lines import along
from caricli.methods.faces.encode_landmarks import landmark_encoder
from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.methods.sketch.model_coarse import misfit
from caricli.methods.sketch.network_coarse import network_coarse
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import SketchModel
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.store.models import load_model
from caricli.structures.sketch import Sketch, Stroke


@pytest.fixture(scope="module")
def network(model, handles):
    """One that has learnt nothing: its latent is zero, the mean face, and its camera nearly right."""
    names = tuple(curve.name for curve in handles.curves)
    size = SketchSize(8, (8, 12, 16), (0, 1, 1), 16, 24, 6)
    made = SketchNetwork(size, len(names), POINTS, 128, torch.Generator().manual_seed(0))
    made.start[-3] = np.log(7.0)
    usual = made.lines.usual
    for row, curve in enumerate(handles.curves):
        line = 7.0 * model.mean[curve.vertices, :2] * [1, -1]
        usual[row] = torch.from_numpy(along(line[None], np.linspace(0, 1, POINTS)[None])[0])
    return SketchModel(made, 64, names, model.model_id)


@pytest.fixture(scope="module")
def see(network, model):
    return partial(see_sketch, network=network, basis=model)


@pytest.fixture(scope="module")
def encoder(model):
    return landmark_encoder(model, load_model())


def test_the_network_says_the_shape_and_the_lines_the_camera(see, sketch, handles, model, encoder):
    lines = lines_by_curve(sketch)
    face, name = network_coarse(sketch, lines, handles, see, encoder)
    assert name == "network"
    seen = see(sketch)
    camera = seen.require_camera()
    np.testing.assert_allclose(face.vertices, model.decode(seen.require_latent()))
    assert face.model_id == model.model_id
    own = face.require_camera().project(face.vertices[handles.vertices])
    gaps = [handles.places(lines, pixels) - pixels for pixels in (own, camera.project(face.vertices[handles.vertices]))]
    assert np.nanmean(np.abs(gaps[0])) < np.nanmean(np.abs(gaps[1]))


def test_a_face_in_the_terms_of_another_model_keeps_its_shape(see, sketch, handles):
    own = load_model(kind="kernel")
    lines = lines_by_curve(sketch)
    face, name = network_coarse(sketch, lines, handles, see, landmark_encoder(own, load_model()))
    assert name == "network"
    np.testing.assert_array_equal(face.vertices, see(sketch).vertices)
    assert face.model_id == own.model_id
    np.testing.assert_allclose(own.decode(face.require_latent()), face.vertices, atol=0.004)


def test_lines_that_the_network_has_no_face_for_are_met_by_an_elastic_one(see, sketch, handles, encoder):
    """The nose is drawn half as long again, the jaw twice as far below the mouth on one side."""

    def bent(line):
        x, y = (line - 128).T
        return 128 + np.column_stack([x + 0.004 * x * y, y + 0.006 * x * np.maximum(y, 0)])

    drawn = sketch.with_strokes([stroke.moved(bent(stroke.points)) for stroke in sketch.strokes])
    lines = lines_by_curve(drawn)
    face, name = network_coarse(drawn, lines, handles, see, encoder)
    assert name == "elastic"
    seen = replace(see(drawn), camera=face.camera)
    assert misfit(face, lines, handles) < 0.5 * misfit(seen, lines, handles)
    assert face.model_id == encoder.model.model_id


def test_what_draws_no_curve_is_no_face(see, sketch, handles, encoder):
    bare = Sketch(sketch.strokes[:1], sketch.size)
    with pytest.raises(InputError, match="lines of the curves of a face"):
        network_coarse(bare, {}, handles, see, encoder)


def test_a_short_line_is_no_face(see, sketch, handles, encoder):
    brow = Stroke(np.array([[20.0, 20], [60, 24]]), curve="brow_left")
    lines = {"brow_left": [brow.points]}
    with pytest.raises(InputError, match="lines of the curves of a face"):
        network_coarse(Sketch((brow,)), lines, handles, see, encoder)


def test_lines_far_from_any_face_are_doubted(see, model, encoder):
    """A cat: a round head with pointed ears, round eyes, a small nose and whiskers."""

    def ring(centre, radii, turn=2 * np.pi):
        angles = np.linspace(0, turn, 40)
        return np.array(centre) + np.stack([np.cos(angles), np.sin(angles)], 1) * radii

    lines = [ring((128, 140), (80, 70)), ring((98, 125), (16, 12)), ring((158, 125), (16, 12))]
    lines += [ring((114, 166), (14, 10), np.pi), ring((142, 166), (14, 10), np.pi)]
    lines += [np.array(ear, float) for ear in ([(60, 100), (55, 30), (100, 75)], [(196, 100), (201, 30), (156, 75)])]
    lines.append(np.array([(120.0, 150), (136, 150), (128, 160), (120, 150)]))
    for row in (150, 164, 178):
        lines += [np.array([(90.0, 160), (30, row)]), np.array([(166.0, 160), (226, row)])]
    coarse = partial(network_coarse, see=see, encoder=encoder)
    fit = SketchReconstruction(model, coarse).reconstruct(Sketch(tuple(map(Stroke, lines)), (256, 256)))
    assert fit.begun == fit.figures()["coarse"] == "elastic" and "an elastic face" in fit.describe()
    assert fit.strange and "far from any face" in fit.describe() and fit.figures()["strange"]
