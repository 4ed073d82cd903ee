from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.methods.evaluate.evaluate_landmark_map import cycle_errors, measure_landmark_map
from caricli.methods.train.see_faces import SeenFaces
from caricli.methods.train.train_landmark_map import learn_landmark_map
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.landmark_map.model import DOMAINS, align

CONFIG = LandmarkMapConfig(dimension=6, width=8, judge_width=8, epochs=3, batch=64)


@pytest.fixture(scope="module")
def world(head_template):
    """Draw faces of both domains: six ways to differ, of which caricatures make more, and noise of their own."""
    generator = np.random.default_rng(5)
    mean = align(head_template.vertices[head_template.annotation.landmarks[:68]][:, :2] * [1, -1])[0]
    ways = 0.05 * generator.normal(size=(6, 68, 2)) * np.linspace(2, 1, 6)[:, None, None]

    def draw(count):
        acts = generator.integers(0, 3, count)
        codes = generator.normal(size=(count, 6)) + 2 * np.eye(6)[acts]
        wild = 1.6 * codes + 0.5 * generator.normal(size=codes.shape)
        points = [align(mean + np.tensordot(each, ways, 1))[0] for each in (codes, wild)]
        return {name: SeenFaces(own, np.eye(3)[acts]) for name, own in zip(DOMAINS, points, strict=True)}

    return draw


@pytest.fixture(scope="module")
def training(world):
    """Normal faces and caricatures of different people."""
    return {name: world(600)[name] for name in DOMAINS}


@pytest.fixture(scope="module")
def trained(training, world):
    unseen = world(100)
    return learn_landmark_map(training, unseen, CONFIG, seed=2), unseen


def test_a_map_trained_without_pairs_finds_the_partner(trained, world):
    (landmark_map, _), _ = trained
    pairs, more = ({name: seen.points for name, seen in world(count).items()} for count in (200, 600))
    errors = measure_landmark_map(landmark_map, pairs, more)["normal"]
    assert errors["paired regression"] <= 1.02 * errors["map"] < 0.6 * errors["identity"]
    assert errors["map"] < errors["mean"]
    assert errors["below identity"] == pytest.approx(100 * (1 - errors["map"] / errors["identity"]))
    assert cycle_errors(landmark_map, pairs)["normal"] < 1


def test_the_same_seed_gives_the_same_map(trained, training):
    (landmark_map, records), unseen = trained
    again, measured = learn_landmark_map(training, unseen, CONFIG, seed=2)
    assert measured == records
    for name, value in landmark_map.tensors().items():
        np.testing.assert_array_equal(again.tensors()[name], value)
    another, _ = learn_landmark_map(training, unseen, CONFIG, seed=3)
    assert any((another.tensors()[name] != value).any() for name, value in landmark_map.tensors().items())


def test_the_epoch_that_is_kept_is_the_best(trained, training):
    (landmark_map, records), unseen = trained
    assert len(records) == CONFIG.epochs + 1
    start, (measured,) = learn_landmark_map(training, unseen, replace(CONFIG, epochs=0), seed=2)
    assert measured == records[0]
    assert min(record["criterion"] for record in records) < measured["criterion"]
    assert any((start.tensors()[name] != value).any() for name, value in landmark_map.tensors().items())


def test_the_start_is_a_map_and_its_inverse(training, world):
    start, _ = learn_landmark_map(training, world(50), replace(CONFIG, epochs=0, least=0.5))
    linear = [start.generators[name]["linear"] for name in DOMAINS]
    np.testing.assert_allclose(linear[0] @ linear[1], np.eye(6), atol=1e-4)
    singular = np.linalg.svd(linear[0])[1]
    assert singular.min() > 0.4999 and singular.max() < 2.0001


def test_faces_that_are_all_the_same_are_refused(training):
    flat = {name: replace(seen, points=np.repeat(seen.points[:1], 600, axis=0)) for name, seen in training.items()}
    with pytest.raises(NumericsError, match="differ"):
        learn_landmark_map(flat, flat, CONFIG)
