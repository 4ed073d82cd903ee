"""Checks that several structures share; each returns what is wrong as "key: expected ..., found ...", or None."""

import numpy as np

from caricli.errors import InputError
from caricli.limits import MAX_COORDINATE, MAX_NUMBER

_APART = 1e-6
"""Share of the largest coordinate (at least of this number itself) that points which are apart span."""


def refuse(*problems: str | None) -> None:
    """Raise InputError with the first problem, if there is one."""
    for problem in problems:
        if problem:
            raise InputError(problem)


def number_problem(key: str, values: np.ndarray, most: float = MAX_NUMBER, noun: str = "numbers") -> str | None:
    """Whether values of any shape are no numbers, not finite, or of a magnitude above ``most``. noun: what they are."""
    kind = values.dtype.kind
    limit = min(most, float(np.finfo(values.dtype).max)) if kind == "f" else most  # half precision ends before many
    if kind not in "biuf" or not ((values >= -limit) & (values <= limit)).all():
        return f"{key}: expected finite {noun} of at most {most:g}, found others"
    return None


def coordinate_problem(key: str, points: np.ndarray) -> str | None:
    """Whether a coordinate is not finite or too large."""
    return number_problem(key, points, MAX_COORDINATE, "coordinates")


def are_apart(points: np.ndarray) -> bool:
    """Whether finite points (N, D) do not all lie in one place."""
    return bool(np.ptp(points, axis=0).max() > _APART * max(_APART, np.abs(points).max()))


def index_problem(key: str, indices: np.ndarray, count: int, distinct: bool = True) -> str | None:
    """Whether rows of indices (P, N) are not padded with -1 at their end, out of range, or name a corner twice."""
    if not padding_is_last(indices):
        return f"{key}: expected rows of at least 3 indices followed by -1 only, found others"
    if indices.max() >= count:
        return f"{key}: expected indices below {count}, found {indices.max()}"
    if distinct and repeats(indices).any():
        return f"{key}: expected distinct corners, found one twice in row {int(np.argmax(repeats(indices)))}"
    return None


def padding_is_last(polygons: np.ndarray) -> bool:
    """Whether each row of (P, N) has at least 3 indices of 0 or more, followed by -1 only."""
    used = polygons >= 0
    return bool((used[:, :3]).all() and (used[:, 1:] <= used[:, :-1]).all() and (polygons >= -1).all())


def repeats(polygons: np.ndarray) -> np.ndarray:
    """The rows (P,) bool of (P, N), padded with -1, that hold an index twice."""
    ordered = np.sort(polygons, axis=1)
    return ((ordered[:, 1:] == ordered[:, :-1]) & (ordered[:, 1:] >= 0)).any(axis=1)


def shape_problem(key: str, value: np.ndarray, shape: tuple, most: float = MAX_NUMBER) -> str | None:
    """Whether an array has another shape (None stands for any length but 0), or holds other numbers than up to most."""
    matches = value.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, value.shape, strict=True))
    if not matches or 0 in value.shape:
        expected = ",".join("*" if n is None else str(n) for n in shape)
        return f"{key}: expected the shape ({expected}), found {value.shape}"
    return number_problem(key, value, most)
