from types import SimpleNamespace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_blendshapes import (
    RIVALS,
    STEADY,
    ComparisonTally,
    KnownCaricature,
    dataset_caricatures,
    dataset_expressions,
    evaluate_blendshapes,
    random_camera,
    rival_figures,
)
from caricli.structures import Face


@pytest.fixture
def data():
    """Stands in for a Dataset of three people, two levels and two expressions; one mesh is missing."""
    keys = [(who, level, what) for who in range(3) for level in (1, 2) for what in (0, 1)][:-1]
    identity, level, expression = np.transpose(keys)
    return SimpleNamespace(
        identity=identity,
        level=level,
        expression=expression,
        vertices=np.arange(len(keys))[:, None, None] * np.ones((1, 4, 3)),
        manifest={"expressions": ["smile", "neutral"], "splits": {"test": [1]}},
        factors={},
    )


def test_caricatures_are_those_of_whom_every_expression_is_there_neutral_first(data):
    data.manifest["splits"]["test"] = [2, 1, 0]
    everyone = dataset_caricatures(data)
    assert [(caricature.identity, caricature.level) for caricature in everyone] == [(0, 2), (1, 2)]
    assert everyone[0].truth[:, 0, 0].tolist() == [3, 2]
    assert len(dataset_caricatures(data, count=1)) == 1
    data.manifest["splits"]["test"] = [1]
    assert [caricature.identity for caricature in dataset_caricatures(data)] == [1]
    data.manifest["splits"]["test"] = [2]
    with pytest.raises(InputError, match="expected caricatures with every expression, found none"):
        dataset_caricatures(data)


def test_what_is_exaggerated_at_random_is_nobodys_expression(data):
    data.manifest["splits"]["test"] = [0, 1]
    data.factors["kind"] = np.where(data.level > 1, 1, 0)
    assert [caricature.identity for caricature in dataset_caricatures(data)] == [0, 1]
    data.factors["kind"][2] = 3
    assert [caricature.identity for caricature in dataset_caricatures(data)] == [1]


def test_expressions_are_those_of_the_bundled_table(data, head):
    expressions = dataset_expressions(data, head.action_names)
    assert [*expressions] == ["neutral", "smile"] and expressions["neutral"] == {} and expressions["smile"]
    for names in (["smile"], ["neutral", "grimace"], []):
        data.manifest["expressions"] = names
        with pytest.raises(InputError, match="dataset of caricli dataset build"):
            dataset_expressions(data, head.action_names)


def test_a_neutral_expression_alone_is_nothing_to_compare(data, head):
    data.manifest["expressions"] = ["neutral"]
    with pytest.raises(InputError, match="expected expressions to compare, found neutral alone"):
        dataset_expressions(data, head.action_names)


def test_a_tally_means_over_what_was_compared():
    tally = ComparisonTally(["neutral", "smile"])
    for shift in (0.0, 1.0):
        error = {name: np.array([np.nan, shift + k]) for k, name in enumerate(RIVALS)}
        figures = {name: {"error": value, "structure": shift} for name, value in error.items()}
        tally.add(KnownCaricature(0, 2, np.zeros((2, 4, 3))), SimpleNamespace(figures=figures))
    assert tally.means["full"] == {"error": 0.5, "structure": 0.5}
    smile, neutral = tally.by_expression["smile"], tally.by_expression["neutral"]
    beside = {"mean": -3.0, "low": -3.0, "high": -3.0}
    means = {name: 0.5 + k for k, name in enumerate(RIVALS)}
    assert smile == means | {"full_is_nearest_on": 2, "of": 2, "beside_transfer": beside}
    assert neutral == {"full_is_nearest_on": 0, "of": 0, "beside_transfer": {}}
    assert tally.differences["transfer"] == beside and [*tally.differences] == [*RIVALS][1:]
    assert tally.summary["caricatures"][1]["rivals"]["full"] == {"error": {"smile": 1.0}, "structure": 1.0}


def test_the_nearest_beats_every_rival_and_faces_of_one_person_count_as_one():
    tally = ComparisonTally(["smile"])
    for person, initial, transfer in ((0, 0.5, 3), (0, 1, 3), (0, 2, 3), (0, 2, 3), (1, 2, 1.5)):
        errors = dict.fromkeys(RIVALS, 4.0) | {"full": 1.0, "initial": initial, "transfer": transfer}
        figures = {name: {"error": np.array([error])} for name, error in errors.items()}
        tally.add(KnownCaricature(person, 2, np.zeros((1, 4, 3))), SimpleNamespace(figures=figures))
    smile = tally.by_expression["smile"]
    assert smile["full_is_nearest_on"] == 3
    assert smile["beside_transfer"] == tally.differences["transfer"] == {"mean": -1.7, "low": -2, "high": -0.5}


def test_errors_are_of_the_whole_head_and_excess_of_what_the_normal_face_moves(head_template):
    still = head_template.vertices
    ways = np.zeros((2, *still.shape))
    ways[1, head_template.mask("chin")] = [0, -0.02, 0]
    face = Face(head_template.with_vertices(still))

    def figures(shapes):
        built = SimpleNamespace(shapes=shapes, normal=still + ways, normal_given=still)
        return rival_figures(built, still + ways, np.array([False, True]), face, head_template)

    own = figures(still + 2.5 * ways)
    share = 100 * 1.5 * 0.02 * head_template.mask("chin").mean() / face.mesh.height
    np.testing.assert_allclose(own["error"], [np.nan, share])
    np.testing.assert_allclose(own["excess"], [np.nan, 150])
    assert figures(np.stack([still, still * [-1, 1, 1]]))["flipped"] > 1


def test_pictures_are_drawn_of_a_seed_and_show_what_is_asked_for(monkeypatch):
    truth = np.arange(3.0)[:, None, None] * np.ones((2, 3)) * [[0, 0.1, 0], [0, 0, 0]] + [[0, 0.2, 0], [0, 0, 0]]
    people = [KnownCaricature(number, 2, truth) for number in range(6)]

    def pictures(*options):
        monkeypatch.setattr(
            "caricli.methods.evaluate.evaluate_blendshapes.compare_blendshapes",
            lambda truth, shows, camera, tools: (shows, camera),
        )
        return [picture for _, picture in evaluate_blendshapes(people, None, *options)]

    assert {shows for shows, _ in pictures()} == {0}
    several = pictures("any", 1)
    assert len({shows for shows, _ in several}) > 1
    for shows, camera in several:
        assert camera.scale * np.ptp(truth[shows, :, 1]) == pytest.approx(400)
    again, other = (pictures("any", seed)[0][1].rotation for seed in (1, 2))
    assert np.array_equal(again, several[0][1].rotation) and not np.array_equal(other, again)


def test_drift_and_strength_are_measured_against_those_of_the_truth(head_template):
    still = head_template.vertices
    steady, chin = head_template.mask(*STEADY), head_template.mask("chin")
    ways = np.zeros((3, *still.shape))
    ways[1:, chin] = [0, -0.02, 0]
    truth = still + ways
    truth[1:, steady] += [0.001, 0, 0]
    weaker = still + 0.5 * ways
    face = Face(head_template.with_vertices(still))
    built = SimpleNamespace(shapes=weaker, normal=still + ways, normal_given=still)
    others = np.array([False, True, True])
    own = rival_figures(built, truth, others, face, head_template)
    best = rival_figures(SimpleNamespace(**vars(built) | {"shapes": truth}), truth, others, face, head_template)
    shift = 100 * 0.001 / face.mesh.height
    np.testing.assert_allclose(best["drift"], [np.nan, shift, shift])
    np.testing.assert_allclose(own["drift"], [np.nan, 0, 0])
    # A face that keeps still is as far off as the truth drifts.
    np.testing.assert_allclose(own["drift_off"], best["drift"])
    np.testing.assert_allclose(best["drift_off"][1:], 0)
    np.testing.assert_allclose(own["strength_off"][1:], 0.5)
    np.testing.assert_allclose(best["strength_off"][1:], 0)


def test_a_head_is_seen_at_one_size_from_the_front():
    for height in (0.2, 0.3):
        camera = random_camera(np.random.default_rng(0), height)
        assert camera.scale * height == pytest.approx(400) and camera.rotation[2, 2] < 0
