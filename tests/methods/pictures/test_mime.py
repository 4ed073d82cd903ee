from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.pictures.mime import GRIN, LAUGH, TWISTS, is_usual_head, random_mime
from caricli.methods.pictures.settings import SitterSettings
from caricli.template.template import Template

STILL = SitterSettings(twisted=0, grinning=0, laughing=0, wide=0, widest=0)
SEEDS = range(24)


def weights_of(head, names, settings, seed):
    """By how much actions moved a face; nothing else did."""
    template = head.template()
    moved = random_mime(template.vertices, template, settings, np.random.default_rng(seed)).ravel()
    actions = np.array([head.actions[head.action_names.index(name)].ravel() for name in names])
    weights, *_ = np.linalg.lstsq(actions.T, moved, rcond=None)
    np.testing.assert_allclose(weights @ actions, moved, atol=1e-7)
    return dict(zip(names, np.round(weights, 6), strict=True))


def test_only_the_open_head_without_parts_of_its_own_is_the_usual_one(head_template, ball):
    assert is_usual_head(head_template)
    assert not is_usual_head(replace(head_template, parts=object()))
    assert not is_usual_head(Template(*ball, annotation=head_template.annotation))


def test_a_twist_pulls_by_one_or_two_actions_a_little(head):
    for seed in SEEDS:
        pulled = [w for w in weights_of(head, TWISTS, replace(STILL, twisted=1), seed).values() if abs(w) > 1e-4]
        assert 1 <= len(pulled) <= 2 and 0.15 <= min(pulled) and max(pulled) <= 0.6


def test_a_grin_is_as_strong_on_both_sides_and_opens_the_jaw_a_little(head):
    for seed in SEEDS:
        weights = weights_of(head, [*GRIN, "jawOpen"], replace(STILL, grinning=1), seed)
        strengths = [weights[name] / most for name, most in GRIN.items()]
        assert np.ptp(strengths) < 1e-4 and 0.4 <= strengths[0] <= 1
        assert -1e-5 <= weights["jawOpen"] <= 0.25


def test_laughs_are_nearly_alike_on_both_sides_with_the_jaw_as_often_closed_as_dropped(head):
    dropped, loudest = [], []
    for seed in SEEDS:
        weights = weights_of(head, [*LAUGH], replace(STILL, laughing=1, loudest=2.4), seed)
        shares = {name: weights[name] / most for name, most in LAUGH.items()}
        for name in (name for name in LAUGH if name.endswith("Left")):
            left, right = shares[name], shares[name.replace("Left", "Right")]
            assert min(left, right) > 0.15
            assert abs(left - right) <= 0.25 * 0.7 * 2.4 and min(left, right) > 0.4 * max(left, right)
        loudest.append(max(shares.values()))
        dropped.append(shares["jawOpen"] > 1e-4)
    assert 0.25 < np.mean(dropped) < 0.75
    assert 1 < max(loudest) <= 2.4


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_a_wide_mouth_is_drawn_to_both_sides_and_what_is_far_from_it_stays(head_template, shift):
    vertices = head_template.vertices + shift
    lips = head_template.annotation.landmarks[48:68]
    mouth = vertices[lips]
    width = np.ptp(mouth[:, 0])
    grown = []
    for seed in SEEDS:
        moved = random_mime(vertices, head_template, replace(STILL, wide=1, widest=1.0), np.random.default_rng(seed))
        assert not moved[:, 1:].any()
        corners = moved[lips[[0, 6]], 0]
        assert corners[0] <= 0 <= corners[1] and abs(corners.sum()) < 0.1 * np.ptp(corners) + 1e-9
        grown.append(np.ptp(corners) / width)
        away = np.linalg.norm(vertices - mouth.mean(0), axis=1) > 2 * width
        assert np.abs(moved[away]).max() < 0.05 * np.abs(moved).max()
    assert 0.55 < max(grown) < 0.8 and min(grown) < 0.15
