"""Sessions as JSON."""

from pathlib import Path
from typing import Any

from caricli.errors import InputError, naming
from caricli.io.files import read_bytes
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json, found_value, parse_json, refuse_others, take
from caricli.limits import MAX_OPERATIONS, MAX_SESSION_BYTES
from caricli.structures.session import Operation, Session, Start

SCHEMA = "caricli.session/1"
_KEYS = ("schema", "start", "operations")


def read_session(path: str | Path) -> Session:
    """Read a session (docs/formats.md). Raises InputError when it is malformed."""
    data = read_bytes(path, MAX_SESSION_BYTES, "a session")
    value = parse_json(data, path)
    with naming(path):
        return session_from_json(value)


def session_from_json(value: Any) -> Session:
    """The Session of a JSON value. Raises InputError when it is malformed."""
    schema = value.get("schema") if isinstance(value, dict) else None
    if schema != SCHEMA:
        raise InputError(f"expected a session of the schema {SCHEMA!r}, found {found_value(schema)}")
    refuse_others(value, _KEYS)
    entries = take(value, "operations", list)
    if len(entries) > MAX_OPERATIONS:
        raise InputError(f"operations: expected at most {MAX_OPERATIONS}, found {len(entries)}")
    operations = []
    for number, entry in enumerate(entries):
        with naming(f"operation {number}"):
            operations.append(operation_from_json(entry))
    return Session(_start(value.get("start")), tuple(operations))


def operation_from_json(entry: Any) -> Operation:
    """The Operation of a JSON value. Raises InputError when it is malformed."""
    if not isinstance(entry, dict):
        raise InputError(f"expected an object with name and parameters, found {type(entry).__name__}")
    refuse_others(entry, ("name", "parameters"))
    return Operation(take(entry, "name", str), take(entry, "parameters", dict, {}))


def session_to_json(session: Session) -> dict[str, Any]:
    """The JSON value of a session."""
    start = session.start
    return {
        "schema": SCHEMA,
        "start": None if start is None else {"file": start.file, "sha256": start.sha256},
        "operations": [operation_to_json(operation) for operation in session.operations],
    }


def operation_to_json(operation: Operation) -> dict[str, Any]:
    """The JSON value of an operation."""
    return {"name": operation.name, "parameters": dict(operation.parameters)}


def write_session(path: str | Path, session: Session) -> None:
    """Write a session, an operation a line. Raises OutputError when the file cannot be written."""
    value = session_to_json(session)
    rows = [format_json(entry, "the session", None).rstrip("\n") for entry in value.pop("operations")]
    head = format_json(value, "the session", None).rstrip("\n").removesuffix("}")
    body = "\n" + ",\n".join(rows) + "\n" if rows else ""
    write_bytes(path, f'{head}, "operations": [{body}]}}\n'.encode())


def _start(entry: Any) -> Start | None:
    if entry is None:
        return None
    if not isinstance(entry, dict):
        raise InputError(f"start: expected an object with file and sha256, or null, found {type(entry).__name__}")
    with naming("start"):
        refuse_others(entry, ("file", "sha256"))
        return Start(take(entry, "file", str), take(entry, "sha256", str))
