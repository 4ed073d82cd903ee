"""Handles of a file."""

from pathlib import Path
from typing import Any

from caricli.errors import InputError, shown
from caricli.io.strict_json import read_json


def load_handles(path: Path | None) -> list[tuple[str, Any]]:
    """Pairs of a place and three lengths, as ``handle_points`` takes them, of a JSON object; none without a path."""
    if path is None:
        return []
    value = read_json(path)
    if not isinstance(value, dict):
        raise InputError(
            f"{shown(path)}: expected a JSON object of places to three lengths, found {type(value).__name__}"
        )
    return list(value.items())
