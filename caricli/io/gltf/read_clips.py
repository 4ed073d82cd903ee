"""What moves in a GLB or glTF file, ours or another program's; nothing in it is trusted."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.gltf.container import read_container
from caricli.io.gltf.document import Document
from caricli.io.strict_json import take
from caricli.structures.track import Clip

_MOST = 10_000
"""Animations, and samplers of one."""


def read_clips(path: str | Path) -> tuple[Clip, ...]:
    """The animations of a file: names, lengths and numbers of frames, in their order.

    path: a GLB file, or a .gltf, without external files.
    Raises InputError when they are malformed.
    """
    content, buffers = read_container(path)
    with naming(path):
        document = Document(content, buffers)
        return tuple(_clip(document, entry) for entry in _objects(content, "animations"))


def _objects(holder: dict, key: str) -> list[dict]:
    entries = take(holder, key, list, [])
    if len(entries) > _MOST or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{key}: expected at most {_MOST} objects, found others")
    return entries


def _clip(document: Document, animation: dict) -> Clip:
    """Frames are the different times of all its samplers; the length is up to the last of them."""
    inputs = [document.item(sampler, "input", "accessors") for sampler in _objects(animation, "samplers")]
    # Samplers share them: each is read once.
    times = [document.accessor(accessor, 1)[:, 0] for accessor in {id(each): each for each in inputs}.values()]
    moments = np.unique(np.concatenate(times)) if times else np.zeros(0)
    name = animation.get("name", "")
    if not isinstance(name, str):
        raise InputError(f"animations: expected a name, found {shown(name, 40)}")
    return Clip(name, float(moments[-1]) if len(moments) else 0.0, len(moments))
