import numpy as np
import pytest
from scipy.optimize import least_squares

from caricli.errors import NumericsError
from caricli.geometry.gauss_newton import Damping, gauss_newton

TARGET = np.array([0.3, -0.8, 1.1, 0.4])


def residuals(x):
    """Four equations in two unknowns, bent a little, that cannot all be met."""
    return np.array([x[0] + 0.1 * x[1] ** 2, x[1], x[0] - x[1], 0.3 * np.sin(x[0])]) - TARGET


def jacobian(x):
    return np.array([[1, 0.2 * x[1]], [0, 1], [1, -1], [0.3 * np.cos(x[0]), 0]])


def normal_equations(x):
    slopes = jacobian(x)
    return slopes.T @ slopes, -slopes.T @ residuals(x)


def test_it_comes_to_the_least_squares_solution():
    expected = least_squares(residuals, np.zeros(2), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    np.testing.assert_allclose(gauss_newton(np.zeros(2), normal_equations, 30), expected, atol=1e-9)


def test_one_step_solves_a_linear_problem():
    generator = np.random.default_rng(0)
    design = generator.normal(size=(7, 3))
    right = generator.normal(size=7)

    def equations(x):
        return design.T @ design, design.T @ (right - design @ x)

    expected = np.linalg.lstsq(design, right, rcond=None)[0]
    np.testing.assert_allclose(gauss_newton(generator.normal(size=3), equations, 1), expected, atol=1e-12)


def test_no_rounds_leave_the_start_and_the_start_is_never_changed():
    start = np.array([0.5, 0.5])
    assert np.array_equal(gauss_newton(start, normal_equations, 0), start)
    gauss_newton(start, normal_equations, 5)
    assert np.array_equal(start, [0.5, 0.5])


@pytest.mark.parametrize(("settled", "calls"), [(0.0, 6), (1e9, 1)])
def test_a_small_step_ends_it(settled, calls):
    points = []

    def equations(x):
        points.append(x)
        return normal_equations(x)

    gauss_newton(np.zeros(2), equations, 6, settled=settled)
    assert len(points) == calls


def test_damped_steps_are_shorter_the_more_they_are_damped():
    system, right = normal_equations(np.zeros(2))
    lengths = [np.linalg.norm(Damping(value, 5, 10).step(system, right)) for value in (0.0, 0.1, 1.0, 100.0)]
    np.testing.assert_allclose(lengths[0], np.linalg.norm(np.linalg.solve(system, right)))
    assert lengths == sorted(lengths, reverse=True)


def test_damping_follows_what_came_of_the_steps():
    damping = Damping(1.0, ease=5.0, tighten=10.0)
    damping.accept()
    assert damping.value == pytest.approx(0.2)
    damping.reject()
    assert damping.value == pytest.approx(2.0)


def test_a_damped_step_goes_down_where_a_full_one_overshoots():
    """x^4 from far away, in residual form x^2: with a system that is far too small only damping helps."""
    x = np.array([3.0])
    system = np.array([[0.5]])
    gradient = np.array([4 * 3.0**3])
    assert (x - np.linalg.solve(system, gradient)) ** 4 > x**4
    damping = Damping(1.0, ease=5.0, tighten=10.0)
    while (x - damping.step(system, gradient)) ** 4 >= x**4:
        damping.reject()
    assert damping.value < 1e4


def test_damped_steps_know_no_units():
    system, right = normal_equations(np.array([0.2, -0.4]))
    units = np.array([1000.0, 0.01])
    step = Damping(0.7, 5, 10).step(system, right)
    other = Damping(0.7, 5, 10).step(system * units[:, None] * units, right * units)
    np.testing.assert_allclose(units * other, step, rtol=1e-9)


@pytest.mark.parametrize("where", ["singular", "system", "right"])
def test_what_has_no_solution_is_refused(where):
    system = np.zeros((2, 2)) if where == "singular" else np.eye(2) * (np.nan if where == "system" else 1)
    right = np.array([1.0, np.inf if where == "right" else 1])
    with pytest.raises(NumericsError, match="a fit has no solution"):
        gauss_newton(np.zeros(2), lambda _: (system, right), 1)
    with pytest.raises(NumericsError, match="a fit has no solution"):
        Damping(1.0, 5, 10).step(system, right)
