import numpy as np
import pytest
import torch

from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.methods.sketch.network_coarse import network_coarse
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import SketchModel
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.structures.sketch import Sketch


@pytest.fixture(scope="module")
def network(model, handles):
    """One that has learnt nothing: its latent is zero, the mean face, and its camera nearly right."""
    names = tuple(curve.name for curve in handles.curves)
    size = SketchSize(8, (8, 12, 16), (0, 1, 1), 16, 24)
    made = SketchNetwork(size, len(names), POINTS, 128, torch.Generator().manual_seed(0))
    made.start[-3] = np.log(7.0)
    return SketchModel(made, 64, names, model.model_id)


def test_the_network_says_the_shape_and_the_lines_the_camera(network, sketch, handles, model):
    lines = lines_by_curve(sketch)
    face = network_coarse(sketch, lines, handles, network, model)
    latent, camera = network.reconstruct(sketch)
    np.testing.assert_allclose(face.vertices, model.decode(latent))
    assert face.model_id == model.model_id
    own = face.require_camera().project(face.vertices[handles.vertices])
    gaps = [handles.places(lines, pixels) - pixels for pixels in (own, camera.project(face.vertices[handles.vertices]))]
    assert np.nanmean(np.abs(gaps[0])) < np.nanmean(np.abs(gaps[1]))


def test_where_no_line_is_named_the_camera_is_the_networks(network, sketch, handles, model):
    bare = Sketch(sketch.strokes[:1], sketch.size)
    face = network_coarse(bare, {}, handles, network, model)
    assert face.require_camera().scale == network.reconstruct(bare)[1].scale
