"""YAML settings into a frozen dataclass; whatever the class does not name is refused."""

import dataclasses
import math
import re
import types
import typing

from caricli.errors import InputError, shown
from caricli.io.files import read_text
from caricli.limits import MAX_CONFIG_BYTES, MAX_CONFIG_DEPTH

# YAML 1.1 takes 1e-4 for text, which nobody means.
_EXPONENT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")


def read_config(path, cls, overrides=()):
    """Read settings.

    Parameters: path of a YAML file, or None for the defaults; cls, a dataclass whose fields are bool, int, float, str,
    list[T], tuple[T, ...], tuple[T, U] or any of these with None; overrides, "key=value" texts that win over the file,
    each value in YAML.
    Returns: an instance of cls.
    Raises: InputError for tags, anchors, duplicate or unknown keys, a wrong type, a number that is not finite, a
    missing field, or a value that the class refuses with ValueError.
    """
    name = shown(path) if path is not None else "settings"
    values = {}
    if path is not None:
        values = _parse(read_text(path, MAX_CONFIG_BYTES, "a YAML file"), name)
        if values is None:
            values = {}
        if not isinstance(values, dict):
            raise InputError(f"{name}: expected 'key: value' lines, found {shown(values, 60)!r}")
    hints = typing.get_type_hints(cls)
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}
    settings = {key: _known(key, value, fields, hints, name) for key, value in values.items()}
    for override in overrides:
        key, separator, text = override.partition("=")
        if not separator:
            raise InputError(f"expected key=value, found {shown(override, 60)!r}")
        settings[key] = _override(key, text, fields, hints)
    for key, field in fields.items():
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and key not in settings:
            raise InputError(f"{name}: expected the key {key!r}, found none")
    try:
        return cls(**settings)
    except ValueError as error:
        raise InputError(f"{name}: {shown(error, 200)}") from error


def read_yaml(path):
    """Read a YAML file of plain values: no tags, anchors or duplicate keys.

    Raises: InputError.
    """
    return _parse(read_text(path, MAX_CONFIG_BYTES, "a YAML file"), shown(path))


def _known(key, value, fields, hints, name):
    if key not in fields:
        raise InputError(f"{name}: expected one of {', '.join(fields)}, found the key {shown(key, 60)!r}")
    try:
        return _convert(value, hints[key])
    except ValueError:
        expected = _describe(hints[key])
        raise InputError(f"{name}: {key}: expected {expected}, found {shown(value, 60)!r}") from None


def _override(key, text, fields, hints):
    name = f"{shown(key, 60)}={shown(text, 60)}"
    if key in fields and hints[key] is str:
        return text
    return _known(key, _parse(text, name) if text else "", fields, hints, name)


def _parse(text, name):
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
        _refuse_duplicates(yaml.compose(text, Loader=yaml.SafeLoader), name)
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = getattr(error, "problem", None) or getattr(error, "reason", None) or error
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{name}: expected YAML, found {shown(reason, 120)}{where}") from None
    # Dates and numbers that YAML recognises but Python cannot make.
    except (ValueError, OverflowError, TypeError, AttributeError, IndexError, KeyError) as error:
        raise InputError(f"{name}: expected YAML, found {shown(error, 120)}") from None


def _refuse_duplicates(node, name):
    children = getattr(node, "value", None)
    if not isinstance(children, list):
        return
    seen = set()
    for child in children:
        if isinstance(child, tuple):
            key, child = child
            if not isinstance(key.value, str) or key.value == "<<":
                raise InputError(f"{name}: expected plain keys, found {shown(key.value, 60)!r}")
            if key.value in seen:
                raise InputError(f"{name}: expected distinct keys, found {shown(key.value, 60)!r} twice")
            seen.add(key.value)
        _refuse_duplicates(child, name)


def _convert(value, hint):
    """Return value as the type says, or raise ValueError."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
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


def _describe(hint):
    if hint in (None, type(None)):
        return "null"
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_describe(argument) for argument in arguments)
    if origin in (list, tuple):
        return f"a list of {', '.join(_describe(a) for a in arguments if a is not ...)}"
    return {float: "a finite number", int: "a whole number", bool: "true or false", str: "text"}[hint]
