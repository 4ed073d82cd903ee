"""Wavefront OBJ: vertex order, polygons and texture indices are kept exactly."""

import codecs
import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.outputs import write_bytes
from caricli.io.parse_number import parse_number, parse_numbers
from caricli.io.worn import is_plain
from caricli.limits import (
    MAX_COORDINATE,
    MAX_CORNERS,
    MAX_FILE_BYTES,
    MAX_POLYGON_CORNERS,
    MAX_POLYGONS,
    MAX_VERTICES,
)
from caricli.structures import Material, Mesh
from caricli.structures.checks import repeats
from caricli.structures.frame import AXES, UNITS
from caricli.structures.materials import FINISHES, MATERIALS, Finish

_KIND = "an OBJ file"
_SKIN = "face"  # its material
_MAX_LINE_BYTES = 8192
# Words of this many faces are in memory at once.
_BLOCK_ROWS = 16384
# Everything else that the format knows; none of it changes the surface.
_IGNORED = set(
    b"vn vp g o s mg mtllib l p cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con bevel "
    b"c_interp d_interp lod shadow_obj trace_obj ctech stech maplib usemap call csh".split()
)
_CORNERS = {
    "v": re.compile(rb"(?<!\S)-?\d{1,9}(?!\S)"),
    "v/vt": re.compile(rb"(?<!\S)-?\d{1,9}/-?\d{1,9}(?!\S)"),
    "v//vn": re.compile(rb"(?<!\S)-?\d{1,9}//-?\d{1,9}(?!\S)"),
    "v/vt/vn": re.compile(rb"(?<!\S)-?\d{1,9}/-?\d{1,9}/-?\d{1,9}(?!\S)"),
}


def read_obj(path: str | Path) -> Mesh:
    """Read an OBJ file.

    Normals, groups, objects, materials, lines and points are ignored, and so are numbers after x, y, z (weights,
    colours). Texture coordinates count only when every face has them; faces with and without in one file are refused,
    because dropping either part would lose it silently.
    Returns a Mesh, indices from 0.
    Raises InputError naming the line when a coordinate is missing, not finite or beyond MAX_COORDINATE, when an index
    is 0 or out of range, when a face repeats a vertex or has fewer than 3 or more than MAX_POLYGON_CORNERS corners,
    and when there are no vertices or no faces.
    """
    return read_painted_obj(path)[0]


def read_painted_obj(path: str | Path) -> tuple[Mesh, list[str]]:
    """Read an OBJ file as ``read_obj`` does, and the names of the materials of its polygons, (P,), "" without one."""
    data = read_bytes(path, MAX_FILE_BYTES, _KIND)
    with naming(path):
        other = content_kind(data)
        if other:
            raise InputError(f"expected {_KIND}, found {other}")
        records = _Records()
        records.read(data.removeprefix(codecs.BOM_UTF8))
        if not records.vertices.words:
            raise InputError(f"expected {_KIND}, found no vertices")
        if not records.faces.corners:
            raise InputError("expected a mesh with faces, found none")
        vertices = records.vertices.coordinates()
        uvs = records.uvs.coordinates() if records.uvs.words else np.zeros((0, 2))
        polygons, uv_polygons = records.faces.polygons(len(vertices), len(uvs))
        if uv_polygons is None:
            return Mesh(vertices, polygons), records.faces.materials
        return Mesh(vertices, polygons, uvs, uv_polygons), records.faces.materials


def write_obj(
    path: str | Path,
    mesh: Mesh,
    texture: str | None = None,
    mtl: Path | None = None,
    others: Mapping[str, str | Finish | None] | None = None,
    materials: np.ndarray | None = None,
) -> None:
    """Write an OBJ file, and its materials when there is a texture or they are several.

    texture: the file name of a PNG in the same folder, of the skin. others: the same by the name of another material,
    such as eyes, or its Finish where that is not the usual one. mtl: path of the material file to write, in the same
    folder as the OBJ (by default with its stem and the suffix .mtl). materials: (P,) Material of the polygons; all skin
    where there are none.
    Raises OutputError when a texture is no plain file name or has no UVs to sit on, or a file cannot be written.
    """
    path = Path(path)
    lines = [f"# units {UNITS}, axes {AXES}\n"]
    kinds = np.zeros(len(mesh.polygons), int) if materials is None else materials
    surfaces: dict[str, str | Finish | None] = {_name(kind): None for kind in np.unique(kinds).tolist()}
    surfaces[_SKIN] = texture
    surfaces |= {n: own for n, own in (others or {}).items() if isinstance(own, str) or (own and n in surfaces)}
    painted = len(surfaces) > 1 or texture is not None
    if painted:
        mtl = path.with_suffix(".mtl") if mtl is None else Path(mtl)
        _write_materials(path, mesh, surfaces, mtl)
        lines.append(f"mtllib {mtl.name}\n")
    lines.append("v %.9g %.9g %.9g\n" * len(mesh.vertices) % tuple(mesh.vertices.ravel().tolist()))
    used = mesh.polygons >= 0
    corners = mesh.polygons[used] + 1
    corner = " %d"
    if mesh.uvs is not None and mesh.uv_polygons is not None:
        lines.append("vt %.9g %.9g\n" * len(mesh.uvs) % tuple(mesh.uvs.ravel().tolist()))
        corners = np.stack([corners, mesh.uv_polygons[used] + 1], axis=1).ravel()
        corner = " %d/%d"
    # Without it Blender shades every polygon flat, and splits them all where it exports them again.
    lines.append("s 1\n")
    forms = [f"f{corner * n}\n" for n in range(mesh.polygons.shape[1] + 1)]
    rows = [forms[n] for n in used.sum(1).tolist()]
    # Polygons that are not of the material of the one before.
    for start in np.flatnonzero(np.diff(kinds, prepend=-1)).tolist() if painted else ():
        rows[start] = f"usemtl {_name(kinds[start])}\n{rows[start]}"
    lines.append("".join(rows) % tuple(corners.tolist()))
    write_bytes(path, "".join(lines).encode("utf-8"))


def _name(material: int) -> str:
    """Of a Material in the file."""
    return _SKIN if material == Material.SKIN else FINISHES[Material(material)].name


def _write_materials(path: str | Path, mesh: Mesh, surfaces: Mapping[str, str | Finish | None], mtl: Path) -> None:
    """surfaces: file names of pictures by the name of the material, or a Finish, or None for the usual one."""
    pictures = {name: own for name, own in surfaces.items() if isinstance(own, str)}
    if mesh.uvs is None and pictures:
        raise OutputError(f"{shown(path)}: expected a mesh with UVs for the texture, found none")
    texts = []
    for name in (*pictures.values(), mtl.name):
        if not (name and is_plain(name) and name.isprintable()):
            raise OutputError(f"{shown(path)}: expected a plain file name for the material, found {shown(name)!r}")
    for material, own in surfaces.items():
        finish = FINISHES[MATERIALS.get(material, Material.SKIN)] if own is None else own
        colour = finish.colour if isinstance(finish, Finish) else (255, 255, 255)
        shares = " ".join(f"{value / 255:.4g}" for value in colour)
        texts.append(f"newmtl {material}\nKa 1 1 1\nKd {shares}\nKs 0 0 0\nillum 1\n")
        texts.append(f"map_Kd {own}\n" if isinstance(own, str) else "")
    write_bytes(mtl, "".join(texts).encode("utf-8"))


def _fail(number: int, expected: str, text: object) -> NoReturn:
    text = shown(text.strip() if isinstance(text, bytes) else text, 60)
    raise InputError(f"line {number}: expected {expected}, found {text!r}")


@dataclass
class _Coordinates:
    """The lines of one keyword: ``size`` numbers of each, of which there may be up to ``most``."""

    keyword: bytes
    size: int
    most: int
    words: list[bytes] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    """The numbers of the lines, so that every refusal can name one."""

    def add(self, number: int, line: bytes, rest: bytes) -> None:
        """Take a line, of which ``rest`` stands after the keyword."""
        values = rest.split()
        if not self.size <= len(values) <= self.most:
            _fail(number, f"{self.keyword.decode()} with {self.size} to {self.most} numbers", line)
        self.words.extend(values[: self.size])
        self.numbers.append(number)
        if len(self.numbers) > MAX_VERTICES:
            _fail(number, f"at most {MAX_VERTICES} lines {self.keyword.decode()}", line)

    def coordinates(self) -> np.ndarray:
        """The numbers as an array (N, size)."""
        try:
            values = parse_numbers(self.words)
        except ValueError:
            values = None
        if values is None or not np.all(np.abs(values) <= MAX_COORDINATE):
            k, word = next((k, word) for k, word in enumerate(self.words) if not _is_coordinate(word))
            _fail(self.numbers[k // self.size], f"a finite coordinate of at most {MAX_COORDINATE:g}", word)
        return values.reshape(-1, self.size)


@dataclass
class _Corner:
    """What the corners of faces count: vertices or texture coordinates."""

    noun: str
    column: int
    """Where it stands in ``v/vt``."""
    count: int
    above: np.ndarray
    """(P,): how many there are above each face: a negative index counts back from them."""
    table: np.ndarray
    """(P, N) int32, padded with -1: the indices from 0, to be filled in."""


class _Faces:
    """The lines that are faces, with their numbers."""

    def __init__(self) -> None:
        self.corners: list[bytes] = []
        self.numbers: list[int] = []
        self.vertices_above: list[int] = []
        self.uvs_above: list[int] = []
        self.materials: list[str] = []

    def fail(self, row: int, expected: str) -> NoReturn:
        _fail(self.numbers[row], expected, b"f " + self.corners[row])

    def polygons(self, vertex_count: int, uv_count: int) -> tuple[np.ndarray, np.ndarray | None]:
        """The faces as indices of vertices, and where they have them, of texture coordinates."""
        kinds, sizes = self._kinds_and_sizes()
        width = int(sizes.max())
        if len(sizes) * width > MAX_CORNERS:
            raise InputError(f"expected at most {MAX_CORNERS} corners, found {len(sizes)} faces of up to {width}")
        shape = (len(sizes), width)
        above = np.array(self.vertices_above)
        wanted = [_Corner("a vertex", 0, vertex_count, above, np.full(shape, -1, np.int32))]
        if "vt" in kinds[0]:
            above = np.array(self.uvs_above)
            wanted.append(_Corner("a texture coordinate", 1, uv_count, above, np.full(shape, -1, np.int32)))
        for kind in np.unique(kinds):
            rows = np.nonzero(kinds == kind)[0]
            indices = self._indices(rows, str(kind))
            for corner in wanted:
                self._place(corner, rows, sizes[rows], indices[:, corner.column])
        twice = repeats(wanted[0].table)
        if twice.any():
            self.fail(int(np.argmax(twice)), "a face with distinct vertices")
        return wanted[0].table, wanted[1].table if len(wanted) > 1 else None

    def _kinds_and_sizes(self) -> tuple[np.ndarray, np.ndarray]:
        """How the corners of each face are written, (P,) text, and how many it has, (P,) int."""
        kinds: list[str] = []
        sizes: list[int] = []
        for row, line in enumerate(self.corners):
            slashes = line.count(b"/")
            size = len(line.split())
            if not 3 <= size <= MAX_POLYGON_CORNERS:
                self.fail(row, f"a face with 3 to {MAX_POLYGON_CORNERS} corners")
            kinds.append("v" if not slashes else "v//vn" if b"//" in line else "v/vt" if slashes == size else "v/vt/vn")
            sizes.append(size)
        first = "vt" in kinds[0]
        other = next((row for row, kind in enumerate(kinds) if ("vt" in kind) != first), None)
        if other is not None:
            self.fail(other, f"a face {'with' if first else 'without'} texture coordinates like those above")
        return np.array(kinds), np.array(sizes)

    def _indices(self, rows: np.ndarray, kind: str) -> np.ndarray:
        """The numbers of all corners of some faces, written in one way; the first two columns of them."""
        pattern = _CORNERS[kind]
        columns = {"v": 1, "v/vt": 2, "v//vn": 2, "v/vt/vn": 3}[kind]
        blocks = []
        for start in range(0, len(rows), _BLOCK_ROWS):
            block = rows[start : start + _BLOCK_ROWS]
            text = b"\n".join([self.corners[k] for k in block])
            if not _are_all(pattern, text):
                bad = next(k for k in block if not _are_all(pattern, self.corners[k]))
                self.fail(bad, f"corners of the form {kind}")
            words = text.replace(b"/", b" ").split()
            blocks.append(np.fromiter(map(int, words), np.int64, len(words)).reshape(-1, columns)[:, :2])
        return np.concatenate(blocks)

    def _place(self, corner: _Corner, rows: np.ndarray, sizes: np.ndarray, indices: np.ndarray) -> None:
        """Put the indices of some faces, with so many corners each, into the table."""
        above = np.repeat(corner.above[rows], sizes)
        zero_based = np.where(indices < 0, above + indices, indices - 1)
        bad = (zero_based < 0) | (zero_based >= corner.count)
        if bad.any():
            k = int(np.argmax(bad))
            row = rows[int(np.searchsorted(np.cumsum(sizes), k, side="right"))]
            _fail(self.numbers[row], f"the number of {corner.noun} from 1 to {corner.count}", indices[k])
        used = np.arange(corner.table.shape[1]) < sizes[:, None]
        block = np.full(used.shape, -1, np.int32)
        block[used] = zero_based
        corner.table[rows] = block


def _are_all(pattern: re.Pattern[bytes], text: bytes) -> bool:
    """Whether all words of a text are as a pattern says.

    They are counted: fuzzing found Python 3.11.2 to match by possessive repetitions where the last word is cut short.
    """
    return len(pattern.findall(text)) == len(text.split())


class _Records:
    """The lines of one file that matter."""

    def __init__(self) -> None:
        self.vertices = _Coordinates(b"v", 3, 7)
        self.uvs = _Coordinates(b"vt", 2, 3)
        self.faces = _Faces()
        self.material = ""

    def read(self, data: bytes) -> None:
        """Take all lines of a file."""
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        for number, line in _logical_lines(data):
            words = line.split(None, 1)
            if not words or words[0].startswith(b"#") or words[0] in _IGNORED:
                continue
            if words[0] == b"usemtl":
                self.material = words[1].strip().decode("utf-8", "replace") if len(words) > 1 else ""
                continue
            if words[0] not in (b"v", b"vt", b"f"):
                _fail(number, "an OBJ keyword", words[0])
            if len(line) > _MAX_LINE_BYTES:
                _fail(number, f"a line of at most {_MAX_LINE_BYTES} bytes", line)
            rest = words[1].split(b"#", 1)[0] if len(words) > 1 else b""
            if words[0] == b"f":
                self._add_face(number, line, rest)
            else:
                (self.vertices if words[0] == b"v" else self.uvs).add(number, line, rest)

    def _add_face(self, number: int, line: bytes, rest: bytes) -> None:
        faces = self.faces
        faces.corners.append(rest)
        faces.numbers.append(number)
        faces.vertices_above.append(len(self.vertices.numbers))
        faces.uvs_above.append(len(self.uvs.numbers))
        faces.materials.append(self.material)
        if len(faces.corners) > MAX_POLYGONS:
            _fail(number, f"at most {MAX_POLYGONS} faces", line)


def _logical_lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    """The lines with their numbers, those joined that end in a backslash."""
    held = b""
    start = 0
    for number, line in enumerate(io.BytesIO(data), 1):
        if line.endswith((b"\\\n", b"\\")):
            held += line.rstrip(b"\n")[:-1] + b" "
            start = start or number
            if len(held) > _MAX_LINE_BYTES:
                held = held[: _MAX_LINE_BYTES + 1]
            continue
        yield (start, held + line) if held else (number, line)
        held = b""
        start = 0
    if held:
        yield start, held


def _is_coordinate(word: bytes) -> bool:
    try:
        return abs(parse_number(word)) <= MAX_COORDINATE
    except ValueError:
        return False
