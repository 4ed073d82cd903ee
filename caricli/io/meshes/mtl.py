"""The pictures that an OBJ file's materials name."""

import codecs
from pathlib import Path

from caricli.errors import naming
from caricli.io.files import read_bytes
from caricli.io.worn import plain_name
from caricli.limits import MAX_CONFIG_BYTES, MAX_FILE_BYTES

EYES = "eyes"
"""Name of the material of eyes."""


def material_pictures(path: str | Path) -> dict[str, Path]:
    """Find the diffuse pictures of an OBJ file: every `map_Kd` of its first `mtllib`, all in the OBJ's own folder.

    Returns paths of pictures by the name of their material, in the file's order; none for any other kind of file.
    Raises InputError when a file cannot be read, or a name leads out of the folder.
    """
    if Path(path).suffix.lower() != ".obj":
        return {}
    library = next(iter(_named(read_bytes(path, MAX_FILE_BYTES, "an OBJ file"), b"mtllib", path).values()), None)
    if library is None:
        return {}
    return _named(read_bytes(library, MAX_CONFIG_BYTES, "a material file"), b"map_Kd", library)


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
                # MeshLab writes ./ before the name.
                plain = plain_name(name.removeprefix(b"./").decode("utf-8", "replace"))
                files[material] = Path(path).parent / plain
    return files
