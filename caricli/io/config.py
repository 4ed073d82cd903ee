"""YAML settings into a frozen dataclass; whatever the class does not name is refused."""

import dataclasses
import math
import re
import types
import typing
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from caricli.errors import InputError, UsageError, shown
from caricli.io.files import read_text
from caricli.io.parse_number import parse_number, parse_whole
from caricli.limits import MAX_CONFIG_BYTES, MAX_CONFIG_DEPTH

Settings = TypeVar("Settings")

# YAML 1.1 takes 1e-4 for text, which nobody means.
_EXPONENT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+", re.ASCII)
# YAML 1.1 also takes 1_0 for ten, 010 for eight and 1:30 for ninety.
_NUMBERS: dict[str, tuple[Callable[[str], float], str]] = {
    "tag:yaml.org,2002:int": (parse_whole, "a plain decimal number of at most 18 digits"),
    "tag:yaml.org,2002:float": (parse_number, "a plain decimal number that is finite"),
}
"""By YAML's tags how numbers are read, and what they must be."""


def read_config(path: str | Path | None, cls: type[Settings], overrides: Sequence[str] = ()) -> Settings:
    """Read settings.

    path: a YAML file, or None for the defaults. cls: a dataclass whose fields are bool, int, float, str, list[T],
    tuple[T, ...], tuple[T, U] or any of these with None. overrides: "key=value" texts of --set that win over the
    file, each value in YAML.
    Returns an instance of cls.
    Raises InputError for tags, anchors, duplicate or unknown keys, a wrong type, a number that is not finite, a missing
    field, or a value that the class refuses with ValueError; of these UsageError where it is an override's.
    """
    name = shown(path) if path is not None else "settings"
    values = {} if path is None else _read_values(path)
    fields: dict[str, dataclasses.Field] = {field.name: field for field in _init_fields(cls)}
    hints = {key: hint for key, hint in typing.get_type_hints(cls).items() if key in fields}
    settings = {key: _setting(key, value, hints, name) for key, value in values.items()}
    own = dict(settings)
    for override in overrides:
        key, separator, text = override.partition("=")
        if not separator:
            raise UsageError(f"--set: expected key=value, found {shown(override, 60)!r}")
        settings[key] = _override(key, text, hints)
    for key, field in fields.items():
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and key not in settings:
            raise InputError(f"{name}: expected the key {key!r}, found none")
    refusal = _refusal(cls, settings)
    if refusal is None:
        return cls(**settings)
    if not overrides or refusal == _refusal(cls, own):
        raise InputError(f"{name}: {refusal}")
    given = " ".join(f"--set {shown(override, 60)}" for override in overrides)
    raise UsageError(f"{given}: {refusal}")


def settings_of(values: dict[str, Any], cls: type[Settings], name: str) -> Settings:
    """Settings of plain values by name, such as JSON has. cls: as of ``read_config``. name: what messages call them.

    Raises InputError for a wrong type, and for what the class refuses with ValueError.
    """
    hints = typing.get_type_hints(cls)
    try:
        return cls(**{key: _setting(key, value, hints, name) for key, value in values.items()})
    except ValueError as error:
        raise InputError(f"{name}: {shown(error, 200)}") from error


def read_yaml(path: str | Path) -> Any:
    """Read a YAML file of plain values. Raises InputError for tags, anchors and duplicate keys."""
    return _parse(read_text(path, MAX_CONFIG_BYTES, "a YAML file"), shown(path))


def _init_fields(cls: Any) -> list[dataclasses.Field]:
    return [field for field in dataclasses.fields(cls) if field.init]


def _read_values(path: str | Path) -> dict:
    values = read_yaml(path)
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise InputError(f"{shown(path)}: expected 'key: value' lines, found {shown(values, 60)!r}")
    return values


def _setting(key: str, value: Any, hints: dict[str, Any], name: str) -> Any:
    """The value of a key, as its type says."""
    if key not in hints:
        raise InputError(f"{name}: expected one of {', '.join(hints)}, found the key {shown(key, 60)!r}")
    try:
        return _convert(value, hints[key])
    except ValueError:
        expected = _describe(hints[key])
        raise InputError(f"{name}: {key}: expected {expected}, found {shown(value, 60)!r}") from None


def _refusal(cls: Any, settings: dict[str, Any]) -> str | None:
    """What a class says against settings, or None; nothing against those that lack one."""
    try:
        cls(**settings)
    except TypeError:
        return None
    except ValueError as error:
        return shown(error, 200)
    return None


def _override(key: str, text: str, hints: dict[str, Any]) -> Any:
    name = f"--set {shown(key, 60)}={shown(text, 60)}"
    if hints.get(key) is str:
        return text
    try:
        return _setting(key, _parse(text, name) if text else "", hints, name)
    except InputError as error:
        raise UsageError(str(error)) from error


def _parse(text: str, name: str) -> Any:
    import yaml

    try:
        depth = 0
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
                raise InputError(f"{name}: expected plain YAML, found an anchor or alias")
            if getattr(event, "tag", None):
                raise InputError(f"{name}: expected plain YAML, found the tag {shown(event.tag, 60)!r}")
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > MAX_CONFIG_DEPTH:
                raise InputError(f"{name}: expected YAML nested at most {MAX_CONFIG_DEPTH} deep, found more")
        _check_node(yaml.compose(text, Loader=yaml.SafeLoader), name)
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{name}: expected YAML, found {shown(reason, 120)}{where}") from None
    # Dates and numbers that YAML recognises but Python cannot make.
    except (ValueError, OverflowError, TypeError, AttributeError, IndexError, KeyError) as error:
        raise InputError(f"{name}: expected YAML, found {shown(error, 120)}") from None


def _check_node(node: Any, name: str) -> None:
    """Refuse keys that come twice and numbers in other than decimal digits. name: what messages call the node."""
    children = getattr(node, "value", None)
    if not isinstance(children, list):
        _check_scalar(node, name)
        return
    seen: set[str] = set()
    for child in children:
        called = name
        if isinstance(child, tuple):
            key, child = child
            if not isinstance(key.value, str) or key.value == "<<":
                raise InputError(f"{name}: expected plain keys, found {shown(key.value, 60)!r}")
            if key.value in seen:
                raise InputError(f"{name}: expected distinct keys, found {shown(key.value, 60)!r} twice")
            seen.add(key.value)
            called = f"{name}: {shown(key.value, 60)}"
        _check_node(child, called)


def _check_scalar(node: Any, name: str) -> None:
    parse, expected = _NUMBERS.get(getattr(node, "tag", ""), (None, ""))
    # What is not finite is refused with the name of its key.
    if parse is not None and not node.value.lower().endswith((".nan", ".inf")):
        try:
            parse(node.value)
        except ValueError:
            raise InputError(f"{name}: expected {expected}, found {shown(node.value, 60)!r}") from None


def _convert(value: Any, hint: Any) -> Any:
    """The value as the type says, or ValueError."""
    origin = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        for argument in arguments:
            try:
                return _convert(value, argument)
            except ValueError:
                continue
        raise ValueError
    if origin in (list, tuple):
        if not isinstance(value, list):
            raise ValueError
        if origin is list:
            return [_convert(item, arguments[0]) for item in value]
        if len(arguments) == 2 and arguments[1] is ...:
            return tuple(_convert(item, arguments[0]) for item in value)
        return tuple(_convert(item, argument) for item, argument in zip(value, arguments, strict=True))
    if hint in (None, type(None)) and value is None:
        return None
    if hint is float:
        if isinstance(value, str) and _EXPONENT.fullmatch(value):
            value = float(value)
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < math.inf:
            return float(value)
    elif hint in (bool, int, str):
        if type(value) is hint:
            return value
    elif hint not in (None, type(None)):
        raise TypeError(f"settings cannot have the type {hint}")
    raise ValueError


def _describe(hint: Any) -> str:
    if hint in (None, type(None)):
        return "null"
    origin = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_describe(argument) for argument in arguments)
    if origin in (list, tuple):
        return f"a list of {', '.join(_describe(a) for a in arguments if a is not ...)}"
    return {float: "a finite number", int: "a whole number", bool: "true or false", str: "text"}[hint]
