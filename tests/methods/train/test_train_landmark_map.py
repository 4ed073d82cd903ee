from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.methods.evaluate.evaluate_landmark_map import FacePairs, measure_landmark_map
from caricli.methods.train.train_landmark_map import learn_landmark_map
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.landmark_map.model import DOMAINS, align

CONFIG = LandmarkMapConfig(styles=2)


@pytest.fixture(scope="module")
def world(head_template):
    """Draw pairs: normal faces differ in six ways, and caricatures go farther in two directions among these."""
    generator = np.random.default_rng(5)
    mean = align(head_template.vertices[head_template.annotation.landmarks[:68]][:, :2] * [1, -1])[0]
    ways = 0.03 * generator.normal(size=(6, 68, 2)) * np.linspace(2, 1, 6)[:, None, None]
    # Part of what they add could be part of a face, and so is lost.
    added = np.tensordot([[1.5, 1, 0, 0, 0, 0], [0, 0, 1, 0, 1.5, 0]], ways, 1)

    def draw(count):
        normal = mean + np.tensordot(generator.normal(size=(count, 6)), ways, 1)
        wild = normal + 0.5 * added[0] + np.tensordot(generator.normal(size=(count, 2)), added, 1)
        return FacePairs(normal, wild, np.arange(count))

    return draw


@pytest.fixture(scope="module")
def training(world):
    """Normal faces and caricatures of different people."""
    return {name: getattr(world(2000), name) for name in DOMAINS}


@pytest.fixture(scope="module")
def trained(training):
    return learn_landmark_map(training, CONFIG)


@pytest.fixture(scope="module")
def figures(trained, world):
    return measure_landmark_map(trained, world(300), world(600))


def test_a_map_trained_without_pairs_is_nearly_as_good_as_regression_on_pairs(figures):
    for to in DOMAINS:
        errors = {name: own["error"] for name, own in figures[to].items()}
        ceiling = errors["paired regression with draws" if to == "caricature" else "paired regression"]
        assert ceiling <= 1.02 * errors["map"] <= 1.2 * ceiling
        assert errors["map"] < 0.6 * errors["identity"] and errors["map"] < 0.6 * errors["mean"]
        own = figures[to]["map"]
        assert own["low"] < own["below_identity"] < own["high"]
        assert own["below_identity"] == pytest.approx(100 * (1 - errors["map"] / errors["identity"]))


def test_the_nearest_of_ten_helps_only_who_draws_what_caricatures_add(figures):
    errors = {name: own["error"] for name, own in figures["caricature"].items()}
    assert errors["map"] < 0.7 * errors["its likeliest caricature"]
    assert errors["map"] < errors["identity with draws"]
    assert errors["map"] < 0.6 * errors["random caricatures"]


def test_caricatures_are_as_different_as_true_ones(figures):
    assert figures["spread"]["map"] == pytest.approx(figures["spread"]["truth"], rel=0.15)


def test_maps_that_stand_still_or_know_but_the_mean_fail(trained, world):
    still = replace(trained, normal=trained.caricature, to_normal=np.eye(136), styles=1e-9 * trained.styles)
    blind = replace(trained, to_normal=0 * trained.to_normal)
    pairs, more = world(100), world(300)
    one, other = (measure_landmark_map(each, pairs, more) for each in (still, blind))
    assert one["normal"]["map"]["below_identity"] == pytest.approx(0, abs=1e-5)
    assert one["caricature"]["map"]["below_identity"] == pytest.approx(0, abs=1e-5)
    assert one["spread"]["map"] < 1e-5 < one["spread"]["truth"]
    assert other["normal"]["map"] == other["normal"]["mean"]


def test_the_order_of_faces_and_who_they_are_of_tells_nothing(trained, training):
    turned = {name: points[::-1] for name, points in training.items()}
    again = learn_landmark_map(turned, CONFIG)
    for name, value in trained.tensors().items():
        np.testing.assert_allclose(abs(again.tensors()[name]), abs(value), atol=1e-4)


def test_no_more_styles_are_learnt_than_there_are(training):
    assert len(learn_landmark_map(training, replace(CONFIG, styles=1)).styles) == 1
    found = learn_landmark_map(training, replace(CONFIG, styles=136)).styles
    assert 2 <= len(found) < 30


def test_faces_that_do_not_differ_enough_are_refused(training):
    flat = {name: np.repeat(points[:1], 600, axis=0) for name, points in training.items()}
    with pytest.raises(NumericsError, match="faces that differ"):
        learn_landmark_map(flat, CONFIG)
    tame = training | {"caricature": 0.5 * training["normal"]}
    with pytest.raises(NumericsError, match="more than normal faces"):
        learn_landmark_map(tame, CONFIG)
