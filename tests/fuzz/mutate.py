"""Changes that keep the frame of a file sound, so that what is inside is reached."""

import io
import json
import random
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

NUMBERS = (0, -1, 1, 2, 255, 2**31 - 1, 2**31, 2**62, -(2**63), 1e6, 1e9, 1e15, 1e30, -1e30, 1e308, 1e-320, 0.5, -0.0)
VALUES: tuple[Any, ...] = (
    *NUMBERS,
    None,
    True,
    "",
    "x",
    "1_0",
    "\u0661",
    "é" * 50,
    [],
    {},
    [[]],
    [None],
    {"": 0},
    10**39,
)
TYPES = ("f4", "f8", "f2", "i4", "i8", "u1", "u8", "?", "U3", "S2")

Mutation = Callable[[bytes, random.Random], bytes]
"""Changes the content of a file; raises whatever it likes for one that has no sound frame."""


def mutate_json(data: bytes, rng: random.Random) -> bytes:
    """Change one to three values of a JSON file."""
    return json.dumps(_changed(json.loads(data), rng)).encode()


def _changed(value: Any, rng: random.Random) -> Any:
    for _ in range(rng.randint(1, 3)):
        holders = [holder for holder in _holders(value) if holder]
        if not holders:
            return rng.choice(VALUES)
        # Short holders hold what the file is made of, long ones its numbers.
        holder = min(rng.sample(holders, min(3, len(holders))), key=len) if rng.random() < 0.5 else rng.choice(holders)
        key = rng.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        action = rng.randrange(5)
        if action == 0:
            del holder[key]
        elif action == 1:
            other = rng.choice(holders)
            holder[key] = json.loads(json.dumps(rng.choice(list(other.values()) if isinstance(other, dict) else other)))
        elif action == 2 and isinstance(holder, list):
            holder.extend(holder[: rng.randint(0, 3)])
        else:
            holder[key] = rng.choice(VALUES)
    return value


def _holders(value: Any) -> list[Any]:
    if not isinstance(value, list | dict):
        return []
    children = value.values() if isinstance(value, dict) else value
    return [value, *(holder for child in list(children)[:200] for holder in _holders(child))]


def mutate_arrays(data: bytes, rng: random.Random) -> bytes:
    """Change one or two arrays of an NPZ file, or the bytes of one of its members."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    if rng.random() < 0.1:
        name = rng.choice(list(members))
        members[name] = _scratched(members[name], rng)
    else:
        arrays = {name: np.load(io.BytesIO(content)) for name, content in members.items()}
        for name, array in change_arrays(arrays, rng).items():
            stream = io.BytesIO()
            np.save(stream, array)
            members[name] = stream.getvalue()
        members = {name: content for name, content in members.items() if name in arrays}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def mutate_members(data: bytes, rng: random.Random) -> bytes:
    """Change bytes in a member of a zip archive whose checksums are kept right."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(stream, "w") as copy:
        names = archive.namelist()
        chosen = rng.choice(names)
        for name in names:
            content = archive.read(name)
            copy.writestr(name, _scratched(content, rng) if name == chosen else content)
    return stream.getvalue()


def mutate_tensors(data: bytes, rng: random.Random) -> bytes:
    """Change a tensor of a .safetensors file, or its settings."""
    from safetensors.numpy import load, save

    length = int.from_bytes(data[:8], "little")
    settings = json.loads(data[8 : 8 + length])["__metadata__"]["caricli"]
    tensors = load(data)
    if rng.random() < 0.25:
        settings = mutate_json(settings.encode(), rng).decode()
    else:
        change_arrays(tensors, rng)
    sound = {name: np.ascontiguousarray(array) for name, array in tensors.items() if array.dtype.kind in "biuf"}
    return save(sound, {"caricli": settings})


def mutate_glb(data: bytes, rng: random.Random) -> bytes:
    """Change the document of a GLB, or its binary chunk."""
    length = int.from_bytes(data[12:16], "little")
    text = data[20 : 20 + length]
    rest = data[20 + length :]
    if rng.random() < 0.7:
        text = mutate_json(text, rng)
        text += b" " * (-len(text) % 4)
    else:
        rest = rest[:8] + _scratched(rest[8:], rng, keep=True)
    body = len(text).to_bytes(4, "little") + b"JSON" + text + rest
    return data[:8] + (12 + len(body)).to_bytes(4, "little") + body


def change_arrays(arrays: dict[str, np.ndarray], rng: random.Random) -> dict[str, np.ndarray]:
    """Change one or two arrays in place; returns those."""
    changed = {}
    for _ in range(rng.randint(1, 2)):
        name = rng.choice(list(arrays))
        action = rng.randrange(12)
        if action == 0 and len(arrays) > 1:
            del arrays[name]
            changed.pop(name, None)
        elif action == 1:
            changed[name] = arrays[name] = arrays[rng.choice(list(arrays))]
        else:
            with np.errstate(all="ignore"):
                changed[name] = arrays[name] = _changed_array(arrays[name], action, rng)
    return changed


def _changed_array(array: np.ndarray, action: int, rng: random.Random) -> np.ndarray:
    try:
        if action == 2:
            return array.astype(rng.choice(TYPES))
        if action == 3:
            return array.reshape(
                rng.choice([(-1,), (1, *array.shape), (*array.shape, 1), (-1, 1), (array.size // 3, 3)])
            )
        if action == 4:
            return array[: rng.choice([0, 1, 2, -1])]
        if action == 5:
            return np.concatenate([array, array])
        if action == 6:
            return 0 * array
        if action == 7:
            return array.T
        copy = array.copy()
        number = rng.choice((*NUMBERS, np.nan, np.inf))
        places = [rng.randrange(array.size) for _ in range(rng.choice([1, 1, 5]))]
        copy.reshape(-1)[slice(None) if action == 8 else places] = "é" * 3 if array.dtype.kind == "U" else number
        return copy
    except (ValueError, TypeError, OverflowError, IndexError):
        return array.ravel()


def _scratched(data: bytes, rng: random.Random, keep: bool = False) -> bytes:
    """Other bytes here and there. keep: the length."""
    content = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(content) + 1)
        new = rng.choice([bytes([rng.randrange(256)]), bytes(4), b"\xff" * 4, rng.randbytes(rng.randint(1, 8))])
        content[at : at + (len(new) if keep else rng.randrange(6))] = new
    return bytes(content[: len(data)] if keep else content)
