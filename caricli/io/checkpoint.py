"""Models in one .safetensors file: arrays, and what rebuilds the model as JSON in the header. No code runs on load."""

import json
import math

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.files import content_kind, looks_like_pickle, read_bytes
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json, parse_json
from caricli.limits import MAX_ARRAY_DIMENSIONS, MAX_CHECKPOINT_BYTES, MAX_CHECKPOINT_HEADER_BYTES

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


def write_checkpoint(path, tensors, metadata):
    """Write a model; the same content gives the same bytes.

    Parameters: path; tensors, dict of name to array of float, int or bool; metadata, dict as `write_json` takes it.
    Raises: OutputError when a value is not finite, the metadata has no JSON form or the file cannot be written.
    """
    from safetensors.numpy import save

    arrays = {name: np.asarray(value, order="C") for name, value in tensors.items()}
    for name, array in arrays.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise OutputError(f"{shown(path)}: {shown(name, 60)}: expected finite values, found others")
    write_bytes(path, save(arrays, {_KEY: format_json(metadata, path, indent=None).strip()}))


def read_checkpoint(path):
    """Read a model.

    Parameters: path of a .safetensors file that `write_checkpoint` wrote.
    Returns: (tensors, metadata): dict of name to array, float16 as float32, and the metadata's dict.
    Raises: InputError when it is a pickle or any other file, damaged, not caricli's, or holds values not finite.
    """
    data = read_bytes(path, MAX_CHECKPOINT_BYTES, "a .safetensors model")
    header = _header(data, path)
    start = 8 + int.from_bytes(data[:8], "little")
    metadata = _metadata(header.pop("__metadata__", None), path)
    tensors, at = {}, 0
    entries = [(name, _entry(entry, f"{shown(path)}: {shown(name, 60)}")) for name, entry in header.items()]
    # The format demands that the tensors fill the file without gaps or overlaps.
    for name, (dtype, shape, begin, end) in sorted(entries, key=lambda entry: entry[1][2:]):
        if begin != at or start + end > len(data):
            raise InputError(
                f"{shown(path)}: {shown(name, 60)}: expected bytes from {at} within {len(data) - start}, "
                f"found {begin} to {end}"
            )
        at = end
        tensors[name] = _tensor(data, dtype, shape, start + begin, f"{shown(path)}: {shown(name, 60)}")
    if start + at != len(data):
        raise InputError(f"{shown(path)}: expected {start + at} bytes, found {len(data)}")
    return {name: tensors[name] for name, _ in entries}, metadata


def _header(data, path):
    # A header length can begin with the bytes of a pickle; the brace after it cannot stand in one.
    if data[8:9] != b"{" and (looks_like_pickle(data) or data.startswith(b"PK")):
        raise InputError(
            f"{shown(path)}: expected a .safetensors model, found a pickle or torch file, which could run code on load"
        )
    length = int.from_bytes(data[:8], "little")
    if len(data) < 10 or length > min(MAX_CHECKPOINT_HEADER_BYTES, len(data) - 8) or data[8:9] != b"{":
        found = content_kind(data)
        if found in (None, "binary data"):
            found = "something else or a truncated file"
        raise InputError(f"{shown(path)}: expected a .safetensors model, found {found}")
    return parse_json(data[8 : 8 + length], path)


def _metadata(value, path):
    text = value.get(_KEY) if isinstance(value, dict) else None
    if not isinstance(text, str):
        raise InputError(f"{shown(path)}: expected a model that caricli wrote, found another .safetensors file")
    metadata = parse_json(text.encode("utf-8"), path)
    if not isinstance(metadata, dict):
        raise InputError(f"{shown(path)}: expected the model's settings, found {shown(metadata, 60)!r}")
    return metadata


def _entry(entry, name):
    try:
        if set(entry) != {"dtype", "shape", "data_offsets"}:
            raise ValueError
        dtype, shape, (begin, end) = np.dtype(_DTYPES[entry["dtype"]]), entry["shape"], entry["data_offsets"]
        if not all(type(number) is int and 0 <= number < 2**40 for number in [*shape, begin, end]):
            raise ValueError
    except (TypeError, ValueError, KeyError):
        found = shown(json.dumps(entry), 80)
        raise InputError(f"{name}: expected dtype, shape and data_offsets, found {found}") from None
    if len(shape) > MAX_ARRAY_DIMENSIONS or math.prod(shape) * dtype.itemsize != end - begin:
        raise InputError(f"{name}: expected {end - begin} bytes, found the shape {shown(shape, 60)} of {dtype}")
    return dtype, tuple(shape), begin, end


def _tensor(data, dtype, shape, begin, name):
    array = np.frombuffer(data, dtype, math.prod(shape), begin)
    if dtype.kind == "b" and (array.view(np.uint8) > 1).any():
        raise InputError(f"{name}: expected true or false, found another value")
    if dtype.kind == "f" and not np.isfinite(array).all():
        raise InputError(f"{name}: expected finite values, found others")
    wanted = np.dtype(np.float32) if dtype == np.float16 else dtype.newbyteorder("=")
    return array.astype(wanted).reshape(shape)
