import numpy as np
import pytest

from caricli.methods.evaluate.paired_interval import paired_interval


def test_a_shift_that_all_faces_share_is_sure_and_noise_is_not():
    generator = np.random.default_rng(3)
    noise = generator.normal(size=60)
    people = np.repeat(np.arange(20), 3)
    shifted = paired_interval(noise * 1e-3 - 1, people)
    assert shifted["mean"] == pytest.approx(-1, abs=1e-3) and -1.01 < shifted["low"] < shifted["high"] < -0.99
    around = paired_interval(noise - noise.mean(), people)
    assert around["low"] < 0 < around["high"] and around["mean"] == pytest.approx(0, abs=1e-12)


def test_faces_of_one_person_count_as_one():
    values = np.repeat(np.random.default_rng(0).normal(size=10), 8)
    alike = paired_interval(values, np.repeat(np.arange(10), 8))
    strangers = paired_interval(values, np.arange(80))
    assert alike["high"] - alike["low"] > 2 * (strangers["high"] - strangers["low"])
    assert alike == paired_interval(values, np.repeat(np.arange(10), 8))


def test_what_is_missing_does_not_count():
    values = np.array([1.0, np.nan, 3.0])
    people = np.array([7, 8, 9])
    assert paired_interval(values, people)["mean"] == 2
    assert paired_interval(values * np.nan, people) == {}
