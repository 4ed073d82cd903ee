import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_sketch import (
    CONDITIONS,
    LEFT,
    DrawnHeads,
    SketchRival,
    SketchRivals,
    evaluate_sketch,
    unit,
)
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.model import SketchModel
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.template.feature_curves import feature_curves


@pytest.fixture(scope="module")
def model(head_template, people):
    return PcaModel.train(head_template, people, PcaConfig(6))


@pytest.fixture(scope="module")
def rivals(model):
    """With a network that has learnt nothing, so that it tells the mean face."""
    curves = feature_curves(model.template.annotation)
    generator = torch.Generator().manual_seed(0)
    network = SketchNetwork(SketchSize(4, (4, 4, 4), (0, 0, 0), 4, 4, 4), len(curves), POINTS, 6, generator)
    own = SketchModel(network, 64, tuple(curve.name for curve in curves), "")
    return SketchRivals.of([SketchRival.of(own, model)], model)


@pytest.mark.parametrize(("camera_given", "share"), [(True, 0.35), (False, 0.7)])
def test_a_fit_finds_the_face_of_clean_lines(rivals, model, camera_given, share):
    """Without the camera nothing tells a large head from a near one."""
    latents = model.prior.sample(np.random.default_rng(0), 3)
    shapes = model.decode(latents)
    drawn = rivals.draw(shapes, CONDITIONS["clean"], [0])
    found = rivals.fitted(drawn, 0.003, camera_given)
    error = np.linalg.norm(found - shapes, axis=-1).mean()
    assert error < share * np.linalg.norm(shapes - model.mean, axis=-1).mean()


def test_a_fit_that_trusts_nothing_is_the_mean_face(rivals, model, people):
    drawn = rivals.draw(people[:1], CONDITIONS["noise"], [0])
    assert np.abs(rivals.fit.fit(drawn, 0, 1e6, True)).max() < 1e-6


def test_all_methods_are_measured_under_all_conditions(rivals, model, people):
    calls = []
    heads = DrawnHeads.of(people[:6], rivals)
    assert heads.book is None
    figures = evaluate_sketch(rivals, heads, people[6:9], 3, lambda *call: calls.append(call))
    again = evaluate_sketch(rivals, heads, people[6:9], 3)
    assert figures.as_json() == again.as_json()
    mean = unit(model.template) * np.linalg.norm(people[:6] - model.mean, axis=-1)
    # A network that tells the mean face tells its mirror image, too, which differs a little.
    for method in ("mean face", "network", "network, strokes without names"):
        assert figures.errors[method] == pytest.approx(dict.fromkeys(CONDITIONS, mean.mean()), rel=1e-4)
    np.testing.assert_allclose(figures.maps["mean face"], mean.mean(0))
    assert figures.left["network"] == pytest.approx(dict.fromkeys(LEFT, mean.mean()), rel=1e-4)
    fits = figures.errors["fit of the linear model, camera known"]
    assert fits["clean"] < fits["half"] and fits["clean"] < 0.8 * mean.mean()
    assert calls[0] == (0, 10) and calls[-1] == (10, 10)


def test_networks_of_one_name_are_told_apart(rivals, model):
    twice = SketchRivals.of([rivals.first, rivals.first], model)
    assert list(twice.networks) == ["network", "network (2)"]


def test_some_heads_are_spread_over_all(rivals, people):
    some = DrawnHeads.of(people[:9], rivals).some(3)
    np.testing.assert_array_equal(some.vertices, people[[0, 4, 8]])


def test_a_head_without_a_curve_of_the_network_is_refused(rivals, model):
    network = rivals.first.network
    other = SketchModel(network.network, network.size, ("beard", *network.curves[1:]), "")
    with pytest.raises(InputError, match="beard"):
        SketchRival.of(other, model)
