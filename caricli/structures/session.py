"""What was done to a face, step by step, so that it can be done again."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from caricli.errors import shown
from caricli.limits import MAX_OPERATIONS
from caricli.structures.checks import refuse

DECIMALS = 6
"""Of the numbers of an operation, so that what is written is what was done: a micrometre, a millionth of a pixel."""

_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_FILE_LENGTH = 255
_SHA256 = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Operation:
    """One step of a session.

    name: of small letters, digits and underscores. parameters: values that JSON has, by name; numbers are rounded to
    ``DECIMALS`` here, before anything is done with them. Raises InputError for other values.
    """

    name: str
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the name and round the numbers."""
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            refuse(f"name: expected small letters, digits and underscores, found {shown(repr(self.name), 60)}")
        if not isinstance(self.parameters, Mapping):
            refuse(f"parameters: expected an object, found {type(self.parameters).__name__}")
        object.__setattr__(self, "parameters", _rounded(self.parameters))


@dataclass(frozen=True)
class Start:
    """The file that a session began with. file: its name, without a folder. sha256: of its content."""

    file: str
    sha256: str

    def __post_init__(self) -> None:
        """Check that the file cannot be anywhere else."""
        name = self.file
        plain = isinstance(name, str) and 0 < len(name) <= _FILE_LENGTH and name.isprintable()
        if not plain or "/" in name or "\\" in name or name in (".", ".."):
            refuse(f"file: expected the name of a file without a folder, found {shown(repr(name), 60)}")
        if not isinstance(self.sha256, str) or not _SHA256.fullmatch(self.sha256):
            refuse(f"sha256: expected 64 hexadecimal digits, found {shown(repr(self.sha256), 80)}")


@dataclass(frozen=True)
class Session:
    """Operations in their order. start: Start, or None for the mean face of the model. operations: of Operation.

    Raises InputError when there are too many.
    """

    start: Start | None = None
    operations: tuple[Operation, ...] = ()

    def __post_init__(self) -> None:
        """Check their number."""
        object.__setattr__(self, "operations", tuple(self.operations))
        if len(self.operations) > MAX_OPERATIONS:
            refuse(f"operations: expected at most {MAX_OPERATIONS}, found {len(self.operations)}")


def _rounded(value: Any) -> Any:
    """The value with its numbers rounded, made of dicts, lists, texts, numbers, bools and None alone."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            refuse(f"parameters: expected finite numbers, found {value}")
        # The sign of a zero would be lost to the eye, not to the file.
        return round(value, DECIMALS) + 0.0
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) for key in value):
            refuse("parameters: expected names that are texts, found others")
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    refuse(f"parameters: expected values that JSON has, found {type(value).__name__}")
    raise AssertionError
