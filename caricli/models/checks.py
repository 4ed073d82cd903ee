"""What the description of a file of weights must say."""

from collections.abc import Mapping, Sequence
from typing import Any

from caricli.errors import InputError, shown


def whole_number(value: Any, limits: Sequence[int], name: str) -> int:
    """A whole number of a file's description. limits: least and greatest. Raises InputError for anything else."""
    if type(value) is not int or not limits[0] <= value <= limits[1]:
        raise InputError(f"expected a {name} from {limits[0]} to {limits[1]}, found {shown(value, 60)!r}")
    return value


def check_schema(metadata: Mapping[str, Any], schema: str, kind: str) -> None:
    """Refuse a file's description of another schema. kind: what the file should hold. Raises InputError."""
    if metadata.get("schema") != schema:
        raise InputError(f"expected a {kind} of schema {schema!r}, found {shown(metadata.get('schema'), 60)!r}")
