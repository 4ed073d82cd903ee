"""The pictures that an OBJ file's materials name."""

import codecs
import os
import re
from collections import Counter
from pathlib import Path

from caricli.errors import InputError, naming, shown
from caricli.io.files import read_bytes
from caricli.io.worn import is_plain
from caricli.limits import MAX_CONFIG_BYTES, MAX_FILE_BYTES

_USED = re.compile(rb"^usemtl[ \t]+(.*?)\s*$", re.MULTILINE)


def material_pictures(path: str | Path) -> dict[str, Path]:
    """Find the diffuse pictures of an OBJ file: every `map_Kd` of its first `mtllib`, all in the OBJ's own folder or in
    folders below it.

    Returns paths of pictures by the name of their material, that of most polygons first, else in the file's order; none
    for any other kind of file, and where the library is not there, as where a mesh was copied alone.
    Raises InputError when a file cannot be read, or a name leads out of the folder.
    """
    library = material_library(path)
    # Not by the path's own method, which fails at names too long for any file.
    if library is None or not os.path.exists(library):
        return {}
    pictures = _named(read_bytes(library, MAX_CONFIG_BYTES, "a material file"), b"map_Kd", library)
    polygons = _polygon_counts(read_bytes(path, MAX_FILE_BYTES, "an OBJ file"))
    return {name: pictures[name] for name in sorted(pictures, key=lambda name: -polygons[name])}


def material_library(path: str | Path) -> Path | None:
    """The first `mtllib` of an OBJ file, whether it is there or not; None for any other kind of file. Raises InputError
    as ``material_pictures``."""
    if Path(path).suffix.lower() != ".obj":
        return None
    return next(iter(_named(read_bytes(path, MAX_FILE_BYTES, "an OBJ file"), b"mtllib", path).values()), None)


def _polygon_counts(data: bytes) -> Counter[str]:
    """How many polygons of an OBJ file are of every material."""
    counts: Counter[str] = Counter()
    parts = _USED.split(data)
    for name, lines in zip(parts[1::2], parts[2::2], strict=True):
        counts[name.decode("utf-8", "replace")] += lines.count(b"\nf")
    return counts


def _named(data: bytes, key: bytes, path: str | Path) -> dict[str, Path]:
    """By the material above it, the file beside ``path`` that the first line with a key names."""
    files: dict[str, Path] = {}
    material = ""
    for line in data.removeprefix(codecs.BOM_UTF8).splitlines():
        words = line.split(maxsplit=1)
        if len(words) == 2 and words[0] == b"newmtl":
            material = words[1].strip().decode("utf-8", "replace")
        if len(words) == 2 and words[0] == key and material not in files:
            # Options such as -s 1 1 1 stand before the name.
            name = words[1].split()[-1] if words[1].startswith(b"-") else words[1].strip()
            with naming(path):
                files[material] = _below(Path(path).parent, name.decode("utf-8", "replace"))
    return files


def _below(folder: Path, name: str) -> Path:
    """The file in a folder or below it to which a name leads. Raises InputError where it may lead elsewhere."""
    # MeshLab writes ./ before the name, and programs of Windows its separators.
    parts = name.replace("\\", "/").removeprefix("./").split("/")
    place = folder.joinpath(*parts)
    if not all(part and is_plain(part) for part in parts) or not _is_inside(place.parent, folder):
        raise InputError(f"expected the name of a file beside it or below its folder, found {shown(name, 80)!r}")
    return place


def _is_inside(place: Path, folder: Path) -> bool:
    """Whether a place is a folder or below it, wherever links lead."""
    return Path(os.path.realpath(place)).is_relative_to(os.path.realpath(folder))
