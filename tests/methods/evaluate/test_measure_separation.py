import numpy as np
import pytest

from caricli.methods.evaluate.measure_separation import agreement, measure_separation
from caricli.models.linear_basis import LinearBasis
from caricli.models.morphable.model import MorphableModel, ShapeBases


def test_equal_within_groups_is_one_and_groups_that_mean_nothing_are_zero():
    generator = np.random.default_rng(0)
    groups = np.repeat(np.arange(200), 3)
    assert agreement(generator.normal(size=(200, 4))[groups], groups) == pytest.approx(1)
    assert abs(agreement(generator.normal(size=(600, 4)), groups)) < 0.05
    halves = agreement(generator.normal(size=(200, 4))[groups] + generator.normal(size=(600, 4)), groups)
    assert halves == pytest.approx(0.5, abs=0.06)


def test_groups_of_one_or_nothing_that_varies_tell_nothing():
    assert agreement(np.random.default_rng(0).normal(size=(5, 3)), np.arange(5)) is None
    assert agreement(np.ones((4, 3)), np.array([0, 0, 1, 1])) is None
    assert agreement(np.ones((0, 3)), np.zeros(0, int)) is None


def test_a_model_that_tells_who_from_what_agrees_in_both(head_template):
    generator = np.random.default_rng(1)
    identity, expression = 0.01 * generator.normal(size=(2, 2, *head_template.vertices.shape))
    bases = ShapeBases(head_template.vertices, identity, expression, noise=1e-4)
    model = MorphableModel(head_template, bases, LinearBasis(identity[0], identity))
    who, what = (a.ravel() for a in np.meshgrid(np.arange(6), np.arange(5), indexing="ij"))
    latents = np.hstack([generator.normal(size=(6, 2))[who], generator.normal(size=(5, 2))[what]])
    figures = measure_separation(model, model.decode(latents), who, what)
    assert figures["identity_of_a_person"] > 0.999 and figures["expression_of_an_expression"] > 0.999
    assert figures["identity_of_an_expression"] < 0.3 and figures["expression_of_a_person"] < 0.3
    nobody = measure_separation(model, np.zeros((0, *head_template.vertices.shape)), who[:0], what[:0])
    assert nobody == dict.fromkeys(figures)
