"""The picture that an OBJ file's material names."""

from pathlib import Path

from caricli.errors import InputError, shown
from caricli.io.files import read_bytes
from caricli.limits import MAX_CONFIG_BYTES, MAX_FILE_BYTES

_NAMES = (b"/", b"\\", b"..", b"\0", b":")


def texture_path(path: str | Path) -> Path | None:
    """Find the diffuse picture of an OBJ file: the first `map_Kd` of its first `mtllib`, both in the OBJ's own folder.

    Returns the path of the picture, or None where no material or picture is named, as in any other kind of file.
    Raises InputError when a file cannot be read, or a name leads out of the folder.
    """
    if Path(path).suffix.lower() != ".obj":
        return None
    library = _named(read_bytes(path, MAX_FILE_BYTES, "an OBJ file"), b"mtllib", path)
    if library is None:
        return None
    return _named(read_bytes(library, MAX_CONFIG_BYTES, "a material file"), b"map_Kd", library)


def _named(data: bytes, key: bytes, path: str | Path) -> Path | None:
    """The file beside ``path`` that the first line with a key names, or None."""
    for line in data.splitlines():
        words = line.split(maxsplit=1)
        if len(words) == 2 and words[0] == key:
            # Options such as -s 1 1 1 stand before the name.
            name = words[1].split()[-1] if words[1].startswith(b"-") else words[1].strip()
            if any(part in name for part in _NAMES):
                raise InputError(f"{shown(path)}: expected the name of a file beside it, found {shown(name, 80)!r}")
            return Path(path).parent / name.decode("utf-8", "replace")
    return None
