"""Rigs as binary glTF 2.0, which Blender, Unreal, Unity and three.js open: one mesh with named morph targets."""

import io
import struct
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from caricli import __version__
from caricli.errors import InputError, OutputError
from caricli.io.face import fans
from caricli.io.files import content_kind, read_bytes, shown
from caricli.io.image import read_image
from caricli.limits import (
    MAX_CORNERS,
    MAX_FILE_BYTES,
    MAX_JSON_BYTES,
    MAX_NPZ_BYTES,
    MAX_SHAPES,
    MAX_VERTICES,
)
from caricli.io.outputs import write_bytes
from caricli.io.rig import EYES, SKIN, Rig, rig_problem
from caricli.io.strict_json import format_json, parse_json

SOURCE_VERTEX = "_SOURCE_VERTEX"
"""The vertex attribute that tells which vertex of the rig a vertex, split where the UVs have a seam, comes from."""

_MATERIALS = {SKIN: "skin", EYES: "eyes"}
_COLOURS = {SKIN: [0.7, 0.42, 0.3, 1], EYES: [0.85, 0.83, 0.8, 1]}
_TEXTURES = {SKIN: "texture", EYES: "eye_texture"}
_ROUGHNESS = 0.6
_UNIT = 1e-4

_MAGIC, _VERSION, _JSON, _BIN = b"glTF", 2, b"JSON", b"BIN\0"
_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_DTYPES = {5121: np.dtype("u1"), 5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}
_CODES = {dtype: code for code, dtype in _DTYPES.items()}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_TRIANGLES = 4
_FOR_VERTICES, _FOR_INDICES = 34962, 34963
_LINEAR, _LINEAR_MIPMAP_LINEAR = 9729, 9987
_MAX_STRIDE = 252
# What these extensions change is how things look, never where vertices are.
_HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")
_SAME_PLACE = 1e-5


@dataclass(frozen=True, eq=False)
class Animation:
    """How a rig moves.

    times (T,), seconds, rising, from 0 on; weights (T,K) of the rig's shapes in its order; rotations (T,4) of the head,
    unit quaternions xyzw, or None.
    """

    times: np.ndarray
    weights: np.ndarray
    rotations: np.ndarray | None = None


def write_gltf(path, rig, sparse=False, animation=None):
    """Write a rig as GLB: metres, +y up, +z front; the same rig gives the same bytes.

    One node with one mesh; one primitive for every material; morph targets of positions and normals, their names in
    ``mesh.extras.targetNames``. Vertices are split where the UVs have a seam, and `SOURCE_VERTEX` leads back; those of
    no polygon stand at the end of the first primitive.
    Parameters: path; rig, Rig; sparse, whether of a target only the vertices that move are stored; animation, Animation
    or None.
    Raises: OutputError when the rig could not be read back, the animation does not fit it, or the file cannot be
    written.
    """
    problem = rig_problem(rig) or (animation is not None and _animation_problem(animation, len(rig.names)))
    if problem:
        raise OutputError(f"{shown(path)}: {problem}")
    buffer = _Buffer()
    document = {
        "asset": {"version": f"{_VERSION}.0", "generator": f"caricli {__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "head", "mesh": 0}],
        "meshes": [
            {
                "name": "head",
                "primitives": _primitives(rig, sparse, buffer),
                **({"weights": [0] * len(rig.names), "extras": {"targetNames": list(rig.names)}} if rig.names else {}),
            }
        ],
        **_materials(rig, buffer),
    }
    if animation is not None and (rig.names or animation.rotations is not None):
        document["animations"] = [_animation(animation, buffer)]
    binary = b"".join(buffer.parts)
    document |= {"accessors": buffer.accessors, "bufferViews": buffer.views, "buffers": [{"byteLength": len(binary)}]}
    text = format_json(document, path, indent=None).strip().encode()
    text += b" " * (-len(text) % 4)
    length = _HEADER.size + 2 * _CHUNK.size + len(text) + len(binary)
    if length > MAX_FILE_BYTES:
        raise OutputError(f"{shown(path)}: expected at most {MAX_FILE_BYTES} bytes of GLB, found {length}")
    start = _HEADER.pack(_MAGIC, _VERSION, length) + _CHUNK.pack(len(text), _JSON)
    write_bytes(path, start + text + _CHUNK.pack(len(binary), _BIN) + binary)


def read_gltf(path):
    """Read the first mesh with morph targets of a GLB, or where none has any the first one, ours or another program's.

    Vertices with the same `SOURCE_VERTEX` become one again. Transforms of nodes are left aside: the neutral and its
    displacements stay in the mesh's own frame, as they are stored. Of the materials the base colour's picture is read,
    where it is embedded; the one named "eyes" is that of the eyes. Skins, animations and weights are left aside.
    Parameters: path, a GLB file without external files.
    Returns: Rig, of triangles; polygons only beside UVs or materials.
    Raises: InputError when it is malformed, compressed, has no mesh or is beyond the caps.
    """
    document, binary = _read_chunks(read_bytes(path, MAX_FILE_BYTES, "a GLB file"), path)
    try:
        rig = _Reader(document, binary).rig()
    except _Malformed as error:
        raise InputError(f"{shown(path)}: {error}") from None
    problem = rig_problem(rig)
    if problem:
        raise InputError(f"{shown(path)}: {problem}")
    return rig


def shading_normals(rig, triangles):
    """Area-weighted unit normals of the neutral, and what every shape adds to them.

    Parameters: rig, Rig; triangles (F,3).
    Returns: (V,3) and (K,V,3) float32; +z where a vertex has no triangle with an area; what is added is zero where no
    neighbour moves.
    """
    neutral = np.asarray(rig.neutral, np.float64)
    places = (triangles.ravel(), np.repeat(np.arange(len(triangles)), 3))
    around = sp.csr_matrix((np.ones(triangles.size), places), shape=(len(neutral), len(triangles)))

    def normals(vertices):
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        total = around @ np.cross(b - a, c - a)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.where(length > 0, total / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])

    still = normals(neutral)
    added = np.empty(np.shape(rig.deltas), np.float32)
    for k, delta in enumerate(rig.deltas):
        added[k] = normals(neutral + delta) - still
    return still.astype(np.float32), added


class _Buffer:
    """The binary chunk as it grows, with the views and accessors of its parts."""

    def __init__(self):
        self.parts, self.views, self.accessors, self._length = [], [], [], 0

    def view(self, data, target=None):
        """Append bytes, padded to a multiple of four; returns the number of the view."""
        padding = bytes(-len(data) % 4)
        view = {"buffer": 0, "byteOffset": self._length, "byteLength": len(data)}
        self.views.append(view if target is None else view | {"target": target})
        self.parts += [data, padding]
        self._length += len(data) + len(padding)
        return len(self.views) - 1

    def accessor(self, array, target=None, bounds=False, sparse=False):
        """Append an array (N,) or (N,W), of a type that glTF knows; returns the number of the accessor."""
        array = np.ascontiguousarray(array)
        rows = array.reshape(len(array), -1)
        accessor = {"componentType": _CODES[array.dtype], "count": len(rows), "type": _TYPES[rows.shape[1]]}
        if bounds:
            accessor |= {"min": rows.min(0).tolist(), "max": rows.max(0).tolist()}
        if not sparse:
            accessor["bufferView"] = self.view(array.tobytes(), target)
        elif rows.any():
            # An accessor with neither view nor sparse values is all zeros.
            (where,) = np.nonzero(rows.any(1))
            where = where.astype(_index_dtype(len(rows)))
            accessor["sparse"] = {
                "count": len(where),
                "indices": {"bufferView": self.view(where.tobytes()), "componentType": _CODES[where.dtype]},
                "values": {"bufferView": self.view(rows[where].tobytes())},
            }
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _index_dtype(count):
    # The largest number of a type is the mark of a restart and no index.
    return np.dtype("<u2") if count <= np.iinfo(np.uint16).max else np.dtype("<u4")


def _primitives(rig, sparse, buffer):
    triangles = np.asarray(rig.faces) if rig.polygons is None else fans(np.asarray(rig.polygons))
    materials, corners, uvs = _triangle_materials(rig), np.zeros_like(triangles), np.zeros((1, 2))
    if rig.uvs is not None:
        corners, uvs = fans(np.asarray(rig.uv_polygons)), np.asarray(rig.uvs)
    neutral, deltas = (np.asarray(a, np.float32) for a in (rig.neutral, rig.deltas))
    normals, normal_deltas = shading_normals(rig, triangles)
    keys = triangles.astype(np.int64) * len(uvs) + corners
    loose = np.setdiff1d(np.arange(len(neutral)), triangles) * len(uvs)
    primitives = []
    for number, material in enumerate(np.unique(materials)):
        kept, indices = np.unique(keys[materials == material], return_inverse=True)
        source, corner = np.divmod(np.append(kept, loose), len(uvs))
        loose = loose[:0]
        attributes = {
            "POSITION": buffer.accessor(neutral[source], _FOR_VERTICES, bounds=True),
            "NORMAL": buffer.accessor(normals[source], _FOR_VERTICES),
            SOURCE_VERTEX: buffer.accessor(source.astype(np.float32), _FOR_VERTICES),
        }
        if rig.uvs is not None:
            # glTF counts v from the top.
            flipped = np.stack([uvs[corner, 0], 1 - uvs[corner, 1]], axis=1).astype(np.float32)
            attributes["TEXCOORD_0"] = buffer.accessor(flipped, _FOR_VERTICES)
        target = None if sparse else _FOR_VERTICES
        primitives.append(
            {
                "attributes": attributes,
                "indices": buffer.accessor(indices.ravel().astype(_index_dtype(len(source))), _FOR_INDICES),
                "material": number,
            }
        )
        if rig.names:
            primitives[-1]["targets"] = [
                {
                    "POSITION": buffer.accessor(delta[source], target, bounds=True, sparse=sparse),
                    "NORMAL": buffer.accessor(normal[source], target, sparse=sparse),
                }
                for delta, normal in zip(deltas, normal_deltas, strict=True)
            ]
    return primitives


def _triangle_materials(rig):
    if rig.materials is None:
        return np.full(len(rig.faces) if rig.polygons is None else (np.asarray(rig.polygons)[:, 2:] >= 0).sum(), SKIN)
    return np.repeat(rig.materials, (np.asarray(rig.polygons)[:, 2:] >= 0).sum(1))


def _materials(rig, buffer):
    """The materials in the order of the primitives, with their pictures."""
    materials, images = [], []
    for material in np.unique(_triangle_materials(rig)).tolist():
        surface = {"metallicFactor": 0, "roughnessFactor": _ROUGHNESS}
        image = getattr(rig, _TEXTURES[material])
        # A picture without UVs has no place on the surface.
        if image is None or rig.uvs is None:
            surface["baseColorFactor"] = _COLOURS[material]
        else:
            surface["baseColorTexture"] = {"index": len(images)}
            images.append({"mimeType": "image/png", "bufferView": buffer.view(_png(image))})
        materials.append({"name": _MATERIALS[material], "pbrMetallicRoughness": surface})
    if not images:
        return {"materials": materials}
    return {
        "materials": materials,
        "textures": [{"sampler": 0, "source": k} for k in range(len(images))],
        "images": images,
        "samplers": [{"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP_LINEAR}],
    }


def _png(image):
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image, np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def _animation(animation, buffer):
    times = buffer.accessor(np.asarray(animation.times, np.float32), bounds=True)
    weights = np.asarray(animation.weights, np.float32).ravel()
    outputs = {"weights": weights} if len(weights) else {}
    if animation.rotations is not None:
        outputs["rotation"] = np.asarray(animation.rotations, np.float32)
    return {
        "name": "animation",
        "channels": [{"sampler": k, "target": {"node": 0, "path": path}} for k, path in enumerate(outputs)],
        "samplers": [
            {"input": times, "interpolation": "LINEAR", "output": buffer.accessor(values)}
            for values in outputs.values()
        ],
    }


def _animation_problem(animation, shape_count):
    """Return what is wrong with an animation as "key: expected ..., found ...", or None."""
    times, weights = np.asarray(animation.times, np.float32), np.asarray(animation.weights, np.float32)
    if times.ndim != 1 or not len(times) or not np.isfinite(times).all() or times[0] < 0 or (np.diff(times) <= 0).any():
        return "times: expected seconds that rise from 0 on, found others"
    if weights.shape != (len(times), shape_count) or not np.isfinite(weights).all():
        return f"weights: expected finite numbers {(len(times), shape_count)}, found {weights.shape} or others"
    if animation.rotations is not None:
        rotations = np.asarray(animation.rotations, np.float64)
        sound = rotations.shape == (len(times), 4) and np.isfinite(rotations).all()
        if not sound or np.abs(np.linalg.norm(rotations, axis=1) - 1).max() > _UNIT:
            return f"rotations: expected unit quaternions {(len(times), 4)}, found {rotations.shape} or others"
    return None


class _Malformed(Exception):
    """What is wrong inside a file, as "expected ..., found ..."."""


def _read_chunks(data, path):
    """The document and the binary chunk, a memoryview, of a GLB."""
    if data[:4] != _MAGIC:
        raise InputError(f"{shown(path)}: expected a GLB file, found {content_kind(data) or 'something else'}")
    if len(data) < _HEADER.size + _CHUNK.size:
        raise InputError(f"{shown(path)}: expected a GLB file, found a truncated one")
    _, version, length = _HEADER.unpack_from(data)
    if version != _VERSION:
        raise InputError(f"{shown(path)}: expected glTF {_VERSION}, found version {version}")
    if length != len(data):
        raise InputError(f"{shown(path)}: expected a GLB file of {length} bytes, found {len(data)}")
    chunks, at = [], _HEADER.size
    while at + _CHUNK.size <= length and len(chunks) < 2:
        size, kind = _CHUNK.unpack_from(data, at)
        at += _CHUNK.size
        if size > length - at:
            raise InputError(f"{shown(path)}: expected a chunk of {size} bytes, found {length - at}")
        chunks.append((kind, memoryview(data)[at : at + size]))
        at += size
    kind, text = chunks[0]
    if kind != _JSON or len(text) > MAX_JSON_BYTES:
        raise InputError(f"{shown(path)}: expected at most {MAX_JSON_BYTES} bytes of JSON first, found another chunk")
    document = parse_json(bytes(text).rstrip(b" \0"), path)
    if not isinstance(document, dict):
        raise InputError(f"{shown(path)}: expected a glTF document, found {type(document).__name__}")
    return document, chunks[1][1] if len(chunks) > 1 and chunks[1][0] == _BIN else memoryview(b"")


def _get(parent, key, kind, default=None):
    value = parent.get(key, default)
    if not isinstance(value, kind):
        raise _Malformed(f"{shown(key, 40)}: expected {kind.__name__}, found {type(value).__name__}")
    return value


def _whole(parent, key, least, most, default=None):
    value = parent.get(key, default)
    if type(value) is not int or not least <= value <= most:
        found = shown(value, 40) if isinstance(value, int | float | str) else type(value).__name__
        raise _Malformed(f"{shown(key, 40)}: expected a whole number from {least} to {most}, found {found}")
    return value


class _Reader:
    """A glTF document and its binary chunk; nothing in either is trusted."""

    def __init__(self, document, binary):
        self.document, self.binary = document, binary

    def rig(self):
        """The first mesh with targets, else the first one, as a Rig."""
        for name in _get(self.document, "extensionsRequired", list, []):
            if not isinstance(name, str) or not name.startswith(_HARMLESS):
                raise _Malformed(f"expected plain glTF, found the extension {shown(name, 60)}")
        mesh, primitives = self.first_mesh()
        names = self.names(mesh, len(primitives[0]["targets"]))
        blocks, corners = self.blocks(primitives, len(names))
        positions = self.gather(blocks, "POSITION", 3)
        kept = place = np.arange(len(positions))
        if all(SOURCE_VERTEX in attributes for attributes, _, _ in blocks):
            kept, place = _merged(self.gather(blocks, SOURCE_VERTEX, 1)[:, 0], positions)
        deltas = np.empty((len(names), len(kept), 3), np.float32)
        for k, delta in enumerate(deltas):
            delta[:] = self.gather([(targets[k], targets, count) for _, targets, count in blocks], "POSITION", 3)[kept]
        faces = place[np.concatenate(corners)].astype(np.int32)
        extras = self.materials(primitives, [len(c) for c in corners])
        if all("TEXCOORD_0" in attributes for attributes, _, _ in blocks):
            uvs = self.gather(blocks, "TEXCOORD_0", 2).astype(np.float64)
            extras["uvs"] = np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1)
            extras["uv_polygons"] = np.concatenate(corners).astype(np.int32)
        if "uvs" in extras or "materials" in extras:
            extras["polygons"] = faces
        return Rig(names, positions[kept], deltas, faces, **extras)

    def first_mesh(self):
        """The first mesh with targets, else the first one, and its primitives, all with the same number of targets."""
        still = None
        for mesh in _get(self.document, "meshes", list, []):
            primitives = _get(mesh, "primitives", list) if isinstance(mesh, dict) else []
            if not all(isinstance(primitive, dict) for primitive in primitives):
                raise _Malformed("primitives: expected objects, found others")
            if not any(primitive.get("targets") for primitive in primitives):
                still = still or (primitives and (mesh, [p | {"targets": []} for p in primitives]))
                continue
            numbers = {len(_get(primitive, "targets", list, [])) for primitive in primitives}
            if len(numbers) > 1 or max(numbers) > MAX_SHAPES:
                raise _Malformed(f"targets: expected as many in every primitive, at most {MAX_SHAPES}, found {numbers}")
            return mesh, primitives
        if not still:
            raise _Malformed("expected a mesh, found none")
        return still

    def names(self, mesh, count):
        """The names of the targets, which glTF leaves to custom."""
        extras = mesh.get("extras")
        names = extras.get("targetNames") if isinstance(extras, dict) else None
        if names is None:
            return tuple(f"target_{k}" for k in range(count))
        if not isinstance(names, list) or len(names) != count or not all(isinstance(name, str) for name in names):
            raise _Malformed(f"targetNames: expected {count} names, found others")
        return tuple(names)

    def blocks(self, primitives, shape_count):
        """The distinct vertices of the primitives, (attributes, targets, count), and the triangles of each primitive.

        Primitives that share their vertices share a block; triangles count through all blocks.
        """
        blocks, starts, corners, total = [], {}, [], 0
        for primitive in primitives:
            attributes, targets = _get(primitive, "attributes", dict), primitive["targets"]
            if not all(isinstance(target, dict) for target in targets):
                raise _Malformed("targets: expected objects, found others")
            key = repr((attributes, targets))
            if key not in starts:
                count = _whole(self.item(attributes, "POSITION", "accessors"), "count", 1, MAX_VERTICES)
                starts[key], total = (total, count), total + count
                blocks.append((attributes, targets, count))
                if total > MAX_VERTICES or total * shape_count * 12 > MAX_NPZ_BYTES:
                    raise _Malformed(f"expected at most {MAX_VERTICES} vertices and {MAX_NPZ_BYTES} bytes of "
                                     f"displacements, found {total} vertices and {shape_count} targets")  # fmt: skip
            start, count = starts[key]
            corners.append(start + self.triangles(primitive, count))
            if sum(len(c) for c in corners) > MAX_CORNERS // 3:
                raise _Malformed(f"expected at most {MAX_CORNERS // 3} triangles, found more")
        return blocks, corners

    def triangles(self, primitive, count):
        """The triangles (F,3) of a primitive of so many vertices."""
        mode = primitive.get("mode", _TRIANGLES)
        if mode != _TRIANGLES:
            raise _Malformed(f"mode: expected triangles ({_TRIANGLES}), found {shown(mode, 40)}")
        indices = np.arange(count)
        if "indices" in primitive:
            indices = self.accessor(self.item(primitive, "indices", "accessors"), 1)[:, 0]
        if indices.dtype.kind == "f" or len(indices) % 3 or indices.max() >= count:
            raise _Malformed(f"indices: expected three whole numbers below {count} for every triangle, found others")
        return indices.astype(np.int64).reshape(-1, 3)

    def gather(self, blocks, key, width):
        """A property of all blocks (V,W) float32; zeros where a target has none."""
        return np.concatenate([self.floats(holder, key, width, count) for holder, _, count in blocks])

    def floats(self, holder, key, width, count):
        """Floats (count,W); whole numbers that stand for fractions become those."""
        if key not in holder:
            return np.zeros((count, width), np.float32)
        accessor = self.item(holder, key, "accessors")
        # Before anything is allocated by it.
        if accessor.get("count") != count:
            raise _Malformed(f"{key}: expected {count} values, found {shown(accessor.get('count'), 40)}")
        values = self.accessor(accessor, width)
        if values.dtype.kind == "f":
            return values
        if accessor.get("normalized") is not True:
            raise _Malformed(f"{key}: expected floats, found {values.dtype}")
        return np.float32(1 / np.iinfo(values.dtype).max) * values.astype(np.float32)

    def accessor(self, accessor, width):
        """The values (N,W) of an accessor, sparse ones filled in."""
        if accessor.get("type") != _TYPES[width]:
            raise _Malformed(f"accessor: expected the type {_TYPES[width]}, found {shown(accessor.get('type'), 40)}")
        count, dtype = _whole(accessor, "count", 1, MAX_CORNERS), _dtype(accessor)
        if "bufferView" in accessor:
            values = self.view(accessor, dtype, count, width)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            sparse = _get(accessor, "sparse", dict)
            changed = _whole(sparse, "count", 1, count)
            places, given = (_get(sparse, key, dict) for key in ("indices", "values"))
            where = self.view(places, _dtype(places), changed, 1)[:, 0]
            if where.dtype.kind == "f" or where.max() >= count:
                raise _Malformed(f"sparse: expected indices below {count}, found others")
            values[where] = self.view(given, dtype, changed, width)
        return values

    def view(self, holder, dtype, count, width):
        """A copy of the values (N,W) that lie in a view of the binary chunk, dense or interleaved."""
        view = self.item(holder, "bufferView", "bufferViews")
        start, length = self.extent(view)
        offset, size = _whole(holder, "byteOffset", 0, length, 0), dtype.itemsize * width
        stride = _whole(view, "byteStride", size, _MAX_STRIDE, size)
        if offset + stride * (count - 1) + size > length:
            needed = offset + stride * (count - 1) + size
            raise _Malformed(f"bufferView: expected at least {needed} bytes, found {length}")
        shape, strides = (count, width), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, self.binary, start + offset, strides).copy()

    def extent(self, view):
        """Start and length of a view in the binary chunk."""
        buffer = self.item(view, "buffer", "buffers")
        if "uri" in buffer or view["buffer"] != 0:
            raise _Malformed("buffers: expected one inside the file, found another file")
        start = _whole(view, "byteOffset", 0, len(self.binary), 0)
        return start, _whole(view, "byteLength", 1, len(self.binary) - start)

    def materials(self, primitives, triangle_counts):
        """The materials of the triangles, where there are eyes, and the pictures that are embedded."""
        kinds, extras = [], {}
        for primitive in primitives:
            material = self.item(primitive, "material", "materials") if "material" in primitive else {}
            kinds.append(EYES if material.get("name") == _MATERIALS[EYES] else SKIN)
            image = self.image(material) if _TEXTURES[kinds[-1]] not in extras else None
            if image is not None:
                extras[_TEXTURES[kinds[-1]]] = image
        if EYES in kinds:
            extras["materials"] = np.repeat(kinds, triangle_counts).astype(np.int32)
        return extras

    def image(self, material):
        """The picture (H,W,3) of a material's base colour, or None where none is embedded that can be read."""
        with suppress(_Malformed, InputError), tempfile.TemporaryDirectory() as folder:
            surface = _get(material, "pbrMetallicRoughness", dict)
            texture = self.item(_get(surface, "baseColorTexture", dict), "index", "textures")
            image = self.item(texture, "source", "images")
            start, length = self.extent(self.item(image, "bufferView", "bufferViews"))
            write_bytes(Path(folder) / "image", self.binary[start : start + length])
            return read_image(Path(folder) / "image")
        return None

    def item(self, holder, key, container):
        """The object that a number points to."""
        items = _get(self.document, container, list, [])
        index = holder.get(key)
        if type(index) is not int or not 0 <= index < len(items) or not isinstance(items[index], dict):
            raise _Malformed(f"{shown(key, 40)}: expected the number of one of {len(items)} {container}, found another")
        return items[index]


def _dtype(holder):
    code = _whole(holder, "componentType", min(_DTYPES), max(_DTYPES))
    if code not in _DTYPES:
        raise _Malformed(f"componentType: expected one of {[*_DTYPES]}, found {code}")
    return _DTYPES[code]


def _merged(sources, positions):
    """Where every distinct source first stands, (V,), and which of them every vertex is (M,)."""
    if not ((sources >= 0) & (sources < MAX_VERTICES) & (sources == np.floor(sources))).all():
        raise _Malformed(f"{SOURCE_VERTEX}: expected whole numbers from 0 to {MAX_VERTICES - 1}, found others")
    _, kept, place = np.unique(sources, return_index=True, return_inverse=True)
    if not np.allclose(positions, positions[kept][place], rtol=0, atol=_SAME_PLACE):
        raise _Malformed(f"{SOURCE_VERTEX}: expected one place for every number, found several")
    return kept, place
