"""Wavefront OBJ: vertex order, polygons and texture indices are kept exactly."""

import io
import re
from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.outputs import write_bytes
from caricli.limits import (
    MAX_COORDINATE,
    MAX_CORNERS,
    MAX_FILE_BYTES,
    MAX_POLYGON_CORNERS,
    MAX_POLYGONS,
    MAX_VERTICES,
)
from caricli.structures import Mesh
from caricli.structures.checks import repeats

_KIND = "an OBJ file"
_MAX_LINE_BYTES = 8192
# Words of this many faces are in memory at once.
_BLOCK_ROWS = 16384
# Everything else that the format knows; none of it changes the surface.
_IGNORED = set(
    b"vn vp g o s mg usemtl mtllib l p cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con bevel "
    b"c_interp d_interp lod shadow_obj trace_obj ctech stech maplib usemap call csh".split()
)
_CORNERS = {
    "v": re.compile(rb"(?:\s*+-?\d{1,9}+(?=\s|$))++\s*+"),
    "v/vt": re.compile(rb"(?:\s*+-?\d{1,9}+/-?\d{1,9}+(?=\s|$))++\s*+"),
    "v//vn": re.compile(rb"(?:\s*+-?\d{1,9}+//-?\d{1,9}+(?=\s|$))++\s*+"),
    "v/vt/vn": re.compile(rb"(?:\s*+-?\d{1,9}+/-?\d{1,9}+/-?\d{1,9}+(?=\s|$))++\s*+"),
}


def read_obj(path):
    """Read an OBJ file.

    Normals, groups, objects, materials, lines and points are ignored, and so are numbers after x, y, z (weights,
    colours). Texture coordinates count only when every face has them; faces with and without in one file are refused,
    because dropping either part would lose it silently.
    Parameters: path.
    Returns: Mesh, indices from 0.
    Raises: InputError naming the line when a coordinate is missing, not finite or beyond MAX_COORDINATE, when an index
    is 0 or out of range, when a face repeats a vertex or has fewer than 3 or more than MAX_POLYGON_CORNERS corners,
    and when there are no vertices or no faces.
    """
    data = read_bytes(path, MAX_FILE_BYTES, _KIND)
    found = content_kind(data)
    if found:
        raise InputError(f"{shown(path)}: expected {_KIND}, found {found}")
    records = _Records(path)
    records.read(data)
    if not records.vertices:
        raise InputError(f"{shown(path)}: expected {_KIND}, found no vertices")
    if not records.faces:
        raise InputError(f"{shown(path)}: expected a mesh with faces, found none")
    vertices = records.coordinates(records.vertices, records.vertex_lines, 3)
    uvs = records.coordinates(records.uvs, records.uv_lines, 2) if records.uvs else np.zeros((0, 2))
    polygons, uv_polygons = records.polygons(len(vertices), len(uvs))
    if uv_polygons is None:
        return Mesh(vertices, polygons)
    return Mesh(vertices, polygons, uvs, uv_polygons)


def write_obj(path, mesh, texture=None, mtl=None):
    """Write an OBJ file, and its material when there is a texture.

    Parameters: path; mesh, Mesh; texture, the file name of a PNG in the same folder, or None; mtl, the path of the
    material file to write, in the same folder as `path` (default: `path` with the suffix .mtl).
    Raises: OutputError when the mesh could not be read back, the texture is no plain file name or has no UVs to sit
    on, or a file cannot be written.
    """
    path = Path(path)
    lines = ["# units m, axes +y up, +z front\n"]
    if texture is not None:
        mtl = path.with_suffix(".mtl") if mtl is None else Path(mtl)
        if mesh.uvs is None:
            raise OutputError(f"{shown(path)}: expected a mesh with UVs for the texture, found none")
        for name in (texture, mtl.name):
            if not name or name != Path(name).name or not name.isprintable():
                raise OutputError(f"{shown(path)}: expected a plain file name for the material, found {shown(name)!r}")
        material = f"newmtl face\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {texture}\n"
        write_bytes(mtl, material.encode("utf-8"))
        lines.append(f"mtllib {mtl.name}\n")
    lines.append("v %.9g %.9g %.9g\n" * len(mesh.vertices) % tuple(mesh.vertices.ravel().tolist()))
    used = mesh.polygons >= 0
    corners = mesh.polygons[used] + 1
    corner = " %d"
    if mesh.uvs is not None:
        lines.append("vt %.9g %.9g\n" * len(mesh.uvs) % tuple(mesh.uvs.ravel().tolist()))
        corners = np.stack([corners, mesh.uv_polygons[used] + 1], axis=1).ravel()
        corner = " %d/%d"
    if texture is not None:
        lines.append("usemtl face\n")
    row = [f"f{corner * n}\n" for n in range(mesh.polygons.shape[1] + 1)]
    lines.append("".join([row[n] for n in used.sum(1).tolist()]) % tuple(corners.tolist()))
    write_bytes(path, "".join(lines).encode("utf-8"))


class _Records:
    """The lines of one file that matter, with their numbers, so that every refusal can name one."""

    def __init__(self, path):
        self.path = path
        self.vertices, self.vertex_lines = [], []
        self.uvs, self.uv_lines = [], []
        self.faces, self.face_lines = [], []
        # Vertices and UVs above each face: a negative index counts back from them.
        self.vertices_above, self.uvs_above = [], []

    def fail(self, number, expected, found):
        found = shown(found.strip() if isinstance(found, bytes) else found, 60)
        raise InputError(f"{shown(self.path)}: line {number}: expected {expected}, found {found!r}")

    def read(self, data):
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        for number, line in _logical_lines(data):
            words = line.split(None, 1)
            if not words or words[0].startswith(b"#"):
                continue
            keyword = words[0]
            if keyword in _IGNORED:
                continue
            if keyword not in (b"v", b"vt", b"f"):
                self.fail(number, "an OBJ keyword", keyword)
            if len(line) > _MAX_LINE_BYTES:
                self.fail(number, f"a line of at most {_MAX_LINE_BYTES} bytes", line)
            rest = words[1].split(b"#", 1)[0] if len(words) > 1 else b""
            if keyword == b"f":
                self.faces.append(rest)
                self.face_lines.append(number)
                self.vertices_above.append(len(self.vertex_lines))
                self.uvs_above.append(len(self.uv_lines))
                if len(self.faces) > MAX_POLYGONS:
                    self.fail(number, f"at most {MAX_POLYGONS} faces", line)
                continue
            size, most, values, lines = (
                (3, 7, self.vertices, self.vertex_lines) if keyword == b"v" else (2, 3, self.uvs, self.uv_lines)
            )
            numbers = rest.split()
            if not size <= len(numbers) <= most:
                self.fail(number, f"{keyword.decode()} with {size} to {most} numbers", line)
            values.extend(numbers[:size])
            lines.append(number)
            if len(lines) > MAX_VERTICES:
                self.fail(number, f"at most {MAX_VERTICES} lines {keyword.decode()}", line)

    def coordinates(self, words, lines, size):
        try:
            values = np.fromiter(map(float, words), np.float64, len(words))
        except ValueError:
            values = None
        if values is None or not np.all(np.abs(values) <= MAX_COORDINATE) or b"_" in b"".join(words):
            for k, word in enumerate(words):
                if not _is_coordinate(word):
                    self.fail(lines[k // size], f"a finite coordinate of at most {MAX_COORDINATE:g}", word)
        return values.reshape(-1, size)

    def polygons(self, vertex_count, uv_count):
        kinds, sizes = [], []
        for line, number in zip(self.faces, self.face_lines, strict=True):
            slashes = line.count(b"/")
            size = len(line.split())
            if not 3 <= size <= MAX_POLYGON_CORNERS:
                self.fail(number, f"a face with 3 to {MAX_POLYGON_CORNERS} corners", b"f " + line)
            kind = "v" if not slashes else "v//vn" if b"//" in line else "v/vt" if slashes == size else "v/vt/vn"
            kinds.append(kind)
            sizes.append(size)
        with_uvs = {"vt" in kind for kind in kinds}
        if len(with_uvs) > 1:
            first = "vt" in kinds[0]
            other = next(k for k, kind in enumerate(kinds) if ("vt" in kind) != first)
            expected = "a face with texture coordinates like" if first else "a face without texture coordinates like"
            self.fail(self.face_lines[other], f"{expected} those above", b"f " + self.faces[other])
        sizes = np.array(sizes)
        width = int(sizes.max())
        if len(sizes) * width > MAX_CORNERS:
            raise InputError(
                f"{shown(self.path)}: expected at most {MAX_CORNERS} corners, found {len(sizes)} faces of up to {width}"
            )
        polygons = np.full((len(sizes), width), -1, np.int32)
        uv_polygons = np.full((len(sizes), width), -1, np.int32) if True in with_uvs else None
        kinds = np.array(kinds)
        for kind in np.unique(kinds):
            rows = np.nonzero(kinds == kind)[0]
            indices = self._indices(rows, str(kind))
            used = np.arange(width) < sizes[rows, None]
            self._place(polygons, rows, used, indices[:, 0], self.vertices_above, vertex_count, "a vertex")
            if uv_polygons is not None:
                self._place(uv_polygons, rows, used, indices[:, 1], self.uvs_above, uv_count, "a texture coordinate")
        twice = repeats(polygons)
        if twice.any():
            k = int(np.argmax(twice))
            self.fail(self.face_lines[k], "a face with distinct vertices", b"f " + self.faces[k])
        return polygons, uv_polygons

    def _indices(self, rows, kind):
        pattern = _CORNERS[kind]
        columns = {"v": 1, "v/vt": 2, "v//vn": 2, "v/vt/vn": 3}[kind]
        blocks = []
        for start in range(0, len(rows), _BLOCK_ROWS):
            block = rows[start : start + _BLOCK_ROWS]
            text = b"\n".join([self.faces[k] for k in block])
            if not pattern.fullmatch(text):
                bad = next(k for k in block if not pattern.fullmatch(self.faces[k]))
                self.fail(self.face_lines[bad], f"corners of the form {kind}", b"f " + self.faces[bad])
            words = text.replace(b"/", b" ").split()
            blocks.append(np.fromiter(map(int, words), np.int64, len(words)).reshape(-1, columns)[:, :2])
        return np.concatenate(blocks)

    def _place(self, table, rows, used, indices, above, count, noun):
        above = np.repeat(np.array(above)[rows], used.sum(1))
        zero_based = np.where(indices < 0, above + indices, indices - 1)
        bad = (zero_based < 0) | (zero_based >= count)
        if bad.any():
            k = int(np.argmax(bad))
            row = rows[int(np.searchsorted(np.cumsum(used.sum(1)), k, side="right"))]
            self.fail(self.face_lines[row], f"the number of {noun} from 1 to {count}", indices[k])
        block = np.full(used.shape, -1, np.int32)
        block[used] = zero_based
        table[rows] = block


def _logical_lines(data):
    """Yield (number, line) with lines joined that end in a backslash."""
    held, start = b"", 0
    for number, line in enumerate(io.BytesIO(data), 1):
        if line.endswith((b"\\\n", b"\\")):
            held, start = held + line.rstrip(b"\n")[:-1] + b" ", start or number
            if len(held) > _MAX_LINE_BYTES:
                held = held[: _MAX_LINE_BYTES + 1]
            continue
        yield (start, held + line) if held else (number, line)
        held, start = b"", 0
    if held:
        yield start, held


def _is_coordinate(word):
    try:
        return b"_" not in word and abs(float(word)) <= MAX_COORDINATE
    except ValueError:
        return False
