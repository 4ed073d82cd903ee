"""What a file of weights must hold, and its description say."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.config import settings_of
from caricli.structures.checks import number_problem, refuse
from caricli.structures.sketch import NAME_LENGTH

Size = TypeVar("Size")

_CURVES = 256
"""That a network knows, at most."""


def whole_number(value: Any, limits: Sequence[int], name: str) -> int:
    """A whole number of a file's description. limits: least and greatest. Raises InputError for anything else."""
    if type(value) is not int or not limits[0] <= value <= limits[1]:
        raise InputError(f"expected a {name} from {limits[0]} to {limits[1]}, found {shown(value, 60)!r}")
    return value


def curve_names(names: Any) -> tuple[str, ...]:
    """The names of the curves that a network knows by its file's description. Raises InputError for anything else."""
    sound = isinstance(names, list) and 0 < len(names) <= _CURVES
    if not sound or not all(isinstance(name, str) and 0 < len(name) <= NAME_LENGTH for name in names):
        raise InputError(f"expected 1 to {_CURVES} names of curves, found {shown(names, 60)!r}")
    if len({*names}) < len(names):
        raise InputError(f"expected every curve once, found {shown(names, 60)!r}")
    return tuple(names)


def window_side(value: Any, limits: Sequence[int], step: int) -> int:
    """The side of a network's windows by a file's description, pixels, of which it reduces ``step`` to one.

    limits: least and greatest. Raises InputError for anything else.
    """
    side = whole_number(value, limits, "size")
    if side % step:
        raise InputError(f"expected a size that is a multiple of {step}, found {side}")
    return side


def network_size(about: Any, kind: type[Size]) -> Size:
    """The size of a network by a file's description, a JSON object. kind: its dataclass. Raises InputError."""
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    if not isinstance(about, dict) or sorted(about) != sorted(names):
        raise InputError(f"expected a network of {', '.join(names)}, found {shown(about, 60)!r}")
    return settings_of(about, kind, "network")


def check_schema(metadata: Mapping[str, Any], schema: str, kind: str) -> None:
    """Refuse a file's description of another schema. kind: what the file should hold. Raises InputError."""
    if metadata.get("schema") != schema:
        raise InputError(f"expected a {kind} of schema {schema!r}, found {shown(metadata.get('schema'), 60)!r}")


def fitting_weights(name: str, array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """An array of a file in single precision. Raises InputError where it is of another kind or shape."""
    refuse(number_problem(name, array))
    if array.shape != shape or array.dtype.kind != "f":
        raise InputError(f"{name}: expected {shape}, found {array.dtype} {array.shape}")
    return np.asarray(array, np.float32)


def named_weights(arrays: Mapping[str, np.ndarray], name: str, shape: tuple[int, ...]) -> np.ndarray:
    """The array of a name in single precision. Raises InputError where there is none of this shape."""
    if name not in arrays:
        raise foreign_weights(name)
    return fitting_weights(name, arrays[name], shape)


def foreign_weights(name: str) -> InputError:
    """What is wrong where an array is lacking, or there is none of its name in such a network."""
    return InputError(f"expected the weights of such a network, found others ({shown(name, 60)})")
