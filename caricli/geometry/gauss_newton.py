"""Least squares by Gauss-Newton steps, full or damped after Levenberg and Marquardt."""

from collections.abc import Callable

import numpy as np

from caricli.errors import NumericsError


def gauss_newton(start: np.ndarray, normal_equations: Callable, rounds: int, settled: float = 0.0) -> np.ndarray:
    """Repeat the full step ``x + A(x)^-1 b(x)``.

    start: (D,). normal_equations: called with x, returns the system A (D, D) and the right side b (D,). rounds: at
    most. settled: a step none of whose entries is as large ends it.
    Returns (D,). Raises NumericsError where a system is singular or not finite.
    """
    x = start
    for _ in range(rounds):
        step = _solved(*normal_equations(x))
        x = x + step
        if np.abs(step).max() < settled:
            break
    return x


class Damping:
    """How careful Levenberg-Marquardt steps are: ``(A + damping diag(A))^-1 b``, by what came of the last ones."""

    def __init__(self, value: float, ease: float, tighten: float) -> None:
        """value: to begin with. ease: divides it after a step that lowered the cost; tighten: multiplies it else."""
        self.value = value
        self.ease = ease
        self.tighten = tighten

    def step(self, system: np.ndarray, right: np.ndarray) -> np.ndarray:
        """The step (D,) for a system (D, D) and its right side (D,). Raises NumericsError as ``gauss_newton`` does."""
        return _solved(system + self.value * np.diag(np.diag(system)), right)

    def accept(self) -> None:
        """The last step lowered the cost."""
        self.value /= self.ease

    def reject(self) -> None:
        """The last step did not lower the cost."""
        self.value *= self.tighten


def _solved(system: np.ndarray, right: np.ndarray) -> np.ndarray:
    try:
        if np.isfinite(system).all() and np.isfinite(right).all():
            return np.linalg.solve(system, right)
    except np.linalg.LinAlgError:
        pass
    raise NumericsError("a fit has no solution: do its points, or the directions of its model, lie in one place?")
