"""Models in one .safetensors file: arrays, and what rebuilds the model as JSON in the header. No code runs on load."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import content_kind, looks_like_pickle, read_bytes
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json, parse_json
from caricli.limits import MAX_ARRAY_DIMENSIONS, MAX_CHECKPOINT_BYTES, MAX_CHECKPOINT_HEADER_BYTES
from caricli.structures.checks import number_problem, refuse

_KEY = "caricli"
_DTYPES = {
    "F64": "<f8",
    "F32": "<f4",
    "F16": "<f2",
    "I64": "<i8",
    "I32": "<i4",
    "I16": "<i2",
    "I8": "i1",
    "U64": "<u8",
    "U32": "<u4",
    "U16": "<u2",
    "U8": "u1",
    "BOOL": "?",
}


class _Entry(NamedTuple):
    """Where a tensor lies among the bytes after the header."""

    begin: int
    end: int
    dtype: np.dtype
    shape: tuple[int, ...]


def write_checkpoint(path: str | Path, tensors: Mapping[str, np.ndarray], metadata: dict) -> None:
    """Write a model; the same content gives the same bytes.

    tensors: arrays of float, int or bool by name. metadata: JSON object, as `write_json` takes it.
    Raises OutputError when a value is not finite, the metadata has no JSON form or the file cannot be written.
    """
    from safetensors.numpy import save

    arrays = {name: np.asarray(value, order="C") for name, value in tensors.items()}
    for name, array in arrays.items():
        problem = number_problem(shown(name, 60), array)
        if problem:
            raise OutputError(f"{shown(path)}: {problem}")
    write_bytes(path, save(arrays, {_KEY: format_json(metadata, path, indent=None).strip()}))


def read_checkpoint(path: str | Path) -> tuple[dict[str, np.ndarray], dict]:
    """Read a model, a .safetensors file that `write_checkpoint` wrote.

    Returns the tensors by name, float16 as float32, and the metadata.
    Raises InputError when it is a pickle or any other file, damaged, not caricli's, or holds values not finite.
    """
    data = read_bytes(path, MAX_CHECKPOINT_BYTES, "a .safetensors model")
    header = _header(data, path)
    start = 8 + int.from_bytes(data[:8], "little")
    with naming(path):
        metadata = _metadata(header.pop("__metadata__", None))
        entries = {}
        for name, entry in header.items():
            with naming(shown(name, 60)):
                entries[name] = _entry(entry)
        tensors = _tensors(memoryview(data)[start:], entries)
    return {name: tensors[name] for name in entries}, metadata


def _tensors(content: memoryview, entries: dict[str, _Entry]) -> dict[str, np.ndarray]:
    """The tensors that fill the bytes after the header, which the format demands without gaps or overlaps."""
    tensors = {}
    at = 0
    for name, entry in sorted(entries.items(), key=lambda item: item[1][:2]):
        with naming(shown(name, 60)):
            if entry.begin != at or entry.end > len(content):
                expected = f"bytes from {at} within {len(content)}"
                raise InputError(f"expected {expected}, found {entry.begin} to {entry.end}")
            tensors[name] = _tensor(content, entry)
        refuse(number_problem(shown(name, 60), tensors[name]))
        at = entry.end
    if at != len(content):
        raise InputError(f"expected {at} bytes, found {len(content)}")
    return tensors


def _header(data: bytes, path: str | Path) -> dict[str, Any]:
    # A header length can begin with the bytes of a pickle; the brace after it cannot stand in one.
    is_torch = data.startswith(b"PK") and b"data.pkl" in data
    if data[8:9] != b"{" and (is_torch or looks_like_pickle(data)):
        raise InputError(
            f"{shown(path)}: expected a .safetensors model, found a pickle or torch file, which could run code on load"
        )
    length = int.from_bytes(data[:8], "little")
    if len(data) < 10 or length > min(MAX_CHECKPOINT_HEADER_BYTES, len(data) - 8) or data[8:9] != b"{":
        kind = content_kind(data)
        if kind in (None, "binary data"):
            kind = "something else or a truncated file"
        raise InputError(f"{shown(path)}: expected a .safetensors model, found {kind}")
    return parse_json(data[8 : 8 + length], path)


def _metadata(value: Any) -> dict:
    text = value.get(_KEY) if isinstance(value, dict) else None
    if not isinstance(text, str):
        raise InputError("expected a model that caricli wrote, found another .safetensors file")
    metadata = parse_json(text.encode("utf-8"), "settings")
    if not isinstance(metadata, dict):
        raise InputError(f"expected the model's settings, found {shown(metadata, 60)!r}")
    return metadata


def _entry(entry: Any) -> _Entry:
    try:
        if set(entry) != {"dtype", "shape", "data_offsets"}:
            raise ValueError
        dtype = np.dtype(_DTYPES[entry["dtype"]])
        shape = entry["shape"]
        begin, end = entry["data_offsets"]
        if not all(type(number) is int and 0 <= number < 2**40 for number in [*shape, begin, end]):
            raise ValueError
    except (TypeError, ValueError, KeyError):
        text = shown(json.dumps(entry), 80)
        raise InputError(f"expected dtype, shape and data_offsets, found {text}") from None
    if len(shape) > MAX_ARRAY_DIMENSIONS or math.prod(shape) * dtype.itemsize != end - begin:
        raise InputError(f"expected {end - begin} bytes, found the shape {shown(shape, 60)} of {dtype}")
    return _Entry(begin, end, dtype, tuple(shape))


def _tensor(content: memoryview, entry: _Entry) -> np.ndarray:
    dtype = entry.dtype
    array = np.frombuffer(content, dtype, math.prod(entry.shape), entry.begin)
    if dtype.kind == "b" and (array.view(np.uint8) > 1).any():
        raise InputError("expected true or false, found another value")
    wanted = np.dtype(np.float32) if dtype == np.float16 else dtype.newbyteorder("=")
    return array.astype(wanted).reshape(entry.shape)
