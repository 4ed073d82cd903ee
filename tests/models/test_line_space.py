import numpy as np
import pytest
import torch

from caricli.models.sketch.line_space import LineSpace

CURVES = 5
POINTS = 6
WAYS = 4
NOISE = 0.01


def drawn(count, seed):
    """(count, K, P, 2) lines that differ in WAYS ways, and (count, WAYS) how far."""
    usual = np.random.default_rng(1).normal(size=(CURVES, POINTS, 2))
    ways = 0.2 * np.random.default_rng(2).normal(size=(WAYS, CURVES, POINTS, 2))
    generator = np.random.default_rng(seed)
    numbers = generator.normal(size=(count, WAYS))
    lines = usual + np.tensordot(numbers, ways, 1)
    return lines + NOISE * generator.normal(size=lines.shape), numbers


@pytest.fixture(scope="module")
def space():
    space = LineSpace(CURVES, POINTS, 8)
    lines, _ = drawn(2000, 3)
    space.learn(lines, np.ones((len(lines), CURVES), bool))
    return space


def told(space, lines, there):
    placed, _, _ = space.placed(torch.from_numpy(lines).float(), there)
    return space(placed, there)


def test_what_is_not_drawn_is_expected_as_regression_expects_it(space):
    """An independent way to the conditional mean: least squares from the points that are drawn, on other lines."""
    everything = torch.ones(3000, CURVES, dtype=torch.bool)
    there = torch.tensor([True, False, True, True, False]).expand(3000, -1)
    placed = [space.placed(torch.from_numpy(drawn(3000, seed)[0]).float(), everything)[0] for seed in (4, 5)]
    whole = [space(each, everything)[0].numpy() for each in placed]
    inputs = [np.column_stack([each[:, there[0]].flatten(1).numpy(), np.ones(3000)]) for each in placed]
    expected = inputs[1] @ np.linalg.lstsq(inputs[0], whole[0], rcond=None)[0]
    unknown = torch.where(there[:, :, None, None], placed[1], torch.nan)
    apart = [np.sqrt(((each - whole[1]) ** 2).mean()) for each in (space(unknown, there)[0].numpy(), expected)]
    assert apart[0] < 1.1 * apart[1] < 0.5


def test_numbers_are_independent_of_size_and_place(space):
    lines, _ = drawn(20, 6)
    there = torch.ones(20, CURVES, dtype=torch.bool)
    there[::2, 3] = False
    numbers, left = told(space, lines, there)
    moved, rest = told(space, 3 * lines + [0.5, -2], there)
    np.testing.assert_allclose(moved, numbers, atol=1e-3)
    np.testing.assert_allclose(rest, left, atol=1e-2)
    placed, scale, shift = space.placed(torch.from_numpy(lines).float(), there)
    expected = scale.numpy()[:, None, None, None] * lines + shift.numpy()[:, None, None]
    np.testing.assert_allclose(placed, expected, atol=1e-5)


def test_an_unsteady_hand_leaves_more(space):
    lines, _ = drawn(200, 7)
    there = torch.ones(200, CURVES, dtype=torch.bool)
    there[:, 1] = False
    steady = told(space, lines, there)[1]
    shaken = told(space, lines + 3 * NOISE * np.random.default_rng(8).normal(size=lines.shape), there)[1]
    assert (shaken - steady)[:, [0, 2, 3, 4]].mean(0).min() > 0.5
    assert (steady[:, 1] == 0).all()


def test_few_curves_have_few_numbers_and_some_noise():
    space = LineSpace(1, POINTS, 16)
    lines, _ = drawn(200, 9)
    there = torch.ones(200, 1, dtype=torch.bool)
    space.learn(lines[:, :1], there.numpy())
    numbers, left = told(space, lines[:, :1], there)
    assert NOISE / 3 < space.spread < NOISE and torch.isfinite(left).all()
    assert (numbers[:, 9:] == 0).all() and numbers[:, :9].std(0).min() > 0.1
