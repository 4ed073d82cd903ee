"""GLB files to rigs, ours or another program's; nothing in them is trusted."""

import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.gltf.format import (
    BINARY_CHUNK,
    CHUNK,
    DTYPES,
    HEADER,
    JSON_CHUNK,
    MAGIC,
    MATERIAL_NAMES,
    SOURCE_VERTEX,
    TEXTURE_FIELDS,
    TYPES,
    VERSION,
)
from caricli.io.image import read_image
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import parse_json
from caricli.limits import MAX_CORNERS, MAX_FILE_BYTES, MAX_JSON_BYTES, MAX_NPZ_BYTES, MAX_SHAPES, MAX_VERTICES
from caricli.structures import Material, Mesh, Rig

_TRIANGLES = 4
_MAX_STRIDE = 252
# What these extensions change is how things look, never where vertices are.
_HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")
_SAME_PLACE = 1e-5


def read_gltf(path: Path) -> Rig:
    """Read the first mesh with morph targets of a GLB, or where none has any the first one, ours or another program's.

    Vertices with the same `SOURCE_VERTEX` become one again. Transforms of nodes are left aside: the neutral and its
    displacements stay in the mesh's own frame, as they are stored. Of the materials the base colour's picture is read,
    where it is embedded; the one named "eyes" is that of the eyes. Skins, animations and weights are left aside.
    Parameters: path, a GLB file without external files.
    Returns: Rig, of triangles; polygons only beside UVs or materials.
    Raises: InputError when it is malformed, compressed, has no mesh or is beyond the caps.
    """
    document, binary = _read_chunks(read_bytes(path, MAX_FILE_BYTES, "a GLB file"), path)
    with naming(path):
        return _Reader(document, binary).rig()


def _read_chunks(data, path):
    """The document and the binary chunk, a memoryview, of a GLB."""
    if data[:4] != MAGIC:
        raise InputError(f"{shown(path)}: expected a GLB file, found {content_kind(data) or 'something else'}")
    if len(data) < HEADER.size + CHUNK.size:
        raise InputError(f"{shown(path)}: expected a GLB file, found a truncated one")
    _, version, length = HEADER.unpack_from(data)
    if version != VERSION:
        raise InputError(f"{shown(path)}: expected glTF {VERSION}, found version {version}")
    if length != len(data):
        raise InputError(f"{shown(path)}: expected a GLB file of {length} bytes, found {len(data)}")
    chunks, at = [], HEADER.size
    while at + CHUNK.size <= length and len(chunks) < 2:
        size, kind = CHUNK.unpack_from(data, at)
        at += CHUNK.size
        if size > length - at:
            raise InputError(f"{shown(path)}: expected a chunk of {size} bytes, found {length - at}")
        chunks.append((kind, memoryview(data)[at : at + size]))
        at += size
    kind, text = chunks[0]
    if kind != JSON_CHUNK or len(text) > MAX_JSON_BYTES:
        raise InputError(f"{shown(path)}: expected at most {MAX_JSON_BYTES} bytes of JSON first, found another chunk")
    document = parse_json(bytes(text).rstrip(b" \0"), path)
    if not isinstance(document, dict):
        raise InputError(f"{shown(path)}: expected a glTF document, found {type(document).__name__}")
    return document, chunks[1][1] if len(chunks) > 1 and chunks[1][0] == BINARY_CHUNK else memoryview(b"")


def _get(parent, key, kind, default=None):
    value = parent.get(key, default)
    if not isinstance(value, kind):
        raise InputError(f"{shown(key, 40)}: expected {kind.__name__}, found {type(value).__name__}")
    return value


def _whole(parent, key, least, most, default=None):
    value = parent.get(key, default)
    if type(value) is not int or not least <= value <= most:
        found = shown(value, 40) if isinstance(value, int | float | str) else type(value).__name__
        raise InputError(f"{shown(key, 40)}: expected a whole number from {least} to {most}, found {found}")
    return value


class _Reader:
    """A glTF document and its binary chunk; nothing in either is trusted."""

    def __init__(self, document, binary):
        self.document, self.binary = document, binary

    def rig(self):
        """The first mesh with targets, else the first one, as a Rig."""
        for name in _get(self.document, "extensionsRequired", list, []):
            if not isinstance(name, str) or not name.startswith(_HARMLESS):
                raise InputError(f"expected plain glTF, found the extension {shown(name, 60)}")
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
        places = (None, None)
        if all("TEXCOORD_0" in attributes for attributes, _, _ in blocks):
            uvs = self.gather(blocks, "TEXCOORD_0", 2).astype(np.float64)
            places = np.stack([uvs[:, 0], 1 - uvs[:, 1]], axis=1), np.concatenate(corners).astype(np.int32)
        looks = self.materials(primitives, [len(c) for c in corners])
        return Rig(names, Mesh(positions[kept], faces, *places), deltas, **looks)

    def first_mesh(self):
        """The first mesh with targets, else the first one, and its primitives, all with the same number of targets."""
        still = None
        for mesh in _get(self.document, "meshes", list, []):
            primitives = _get(mesh, "primitives", list) if isinstance(mesh, dict) else []
            if not all(isinstance(primitive, dict) for primitive in primitives):
                raise InputError("primitives: expected objects, found others")
            if not any(primitive.get("targets") for primitive in primitives):
                still = still or (primitives and (mesh, [p | {"targets": []} for p in primitives]))
                continue
            numbers = {len(_get(primitive, "targets", list, [])) for primitive in primitives}
            if len(numbers) > 1 or max(numbers) > MAX_SHAPES:
                raise InputError(f"targets: expected as many in every primitive, at most {MAX_SHAPES}, found {numbers}")
            return mesh, primitives
        if not still:
            raise InputError("expected a mesh, found none")
        return still

    def names(self, mesh, count):
        """The names of the targets, which glTF leaves to custom."""
        extras = mesh.get("extras")
        names = extras.get("targetNames") if isinstance(extras, dict) else None
        if names is None:
            return tuple(f"target_{k}" for k in range(count))
        if not isinstance(names, list) or len(names) != count or not all(isinstance(name, str) for name in names):
            raise InputError(f"targetNames: expected {count} names, found others")
        return tuple(names)

    def blocks(self, primitives, shape_count):
        """The distinct vertices of the primitives, (attributes, targets, count), and the triangles of each primitive.

        Primitives that share their vertices share a block; triangles count through all blocks.
        """
        blocks, starts, corners, total = [], {}, [], 0
        for primitive in primitives:
            attributes, targets = _get(primitive, "attributes", dict), primitive["targets"]
            if not all(isinstance(target, dict) for target in targets):
                raise InputError("targets: expected objects, found others")
            key = repr((attributes, targets))
            if key not in starts:
                count = _whole(self.item(attributes, "POSITION", "accessors"), "count", 1, MAX_VERTICES)
                starts[key], total = (total, count), total + count
                blocks.append((attributes, targets, count))
                if total > MAX_VERTICES or total * shape_count * 12 > MAX_NPZ_BYTES:
                    raise InputError(f"expected at most {MAX_VERTICES} vertices and {MAX_NPZ_BYTES} bytes of "
                                     f"displacements, found {total} vertices and {shape_count} targets")  # fmt: skip
            start, count = starts[key]
            corners.append(start + self.triangles(primitive, count))
            if sum(len(c) for c in corners) > MAX_CORNERS // 3:
                raise InputError(f"expected at most {MAX_CORNERS // 3} triangles, found more")
        return blocks, corners

    def triangles(self, primitive, count):
        """The triangles (F,3) of a primitive of so many vertices."""
        mode = primitive.get("mode", _TRIANGLES)
        if mode != _TRIANGLES:
            raise InputError(f"mode: expected triangles ({_TRIANGLES}), found {shown(mode, 40)}")
        indices = np.arange(count)
        if "indices" in primitive:
            indices = self.accessor(self.item(primitive, "indices", "accessors"), 1)[:, 0]
        if indices.dtype.kind == "f" or len(indices) % 3 or indices.max() >= count:
            raise InputError(f"indices: expected three whole numbers below {count} for every triangle, found others")
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
            raise InputError(f"{key}: expected {count} values, found {shown(accessor.get('count'), 40)}")
        values = self.accessor(accessor, width)
        if values.dtype.kind == "f":
            return values
        if accessor.get("normalized") is not True:
            raise InputError(f"{key}: expected floats, found {values.dtype}")
        return np.float32(1 / np.iinfo(values.dtype).max) * values.astype(np.float32)

    def accessor(self, accessor, width):
        """The values (N,W) of an accessor, sparse ones filled in."""
        if accessor.get("type") != TYPES[width]:
            raise InputError(f"accessor: expected the type {TYPES[width]}, found {shown(accessor.get('type'), 40)}")
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
                raise InputError(f"sparse: expected indices below {count}, found others")
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
            raise InputError(f"bufferView: expected at least {needed} bytes, found {length}")
        shape, strides = (count, width), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, self.binary, start + offset, strides).copy()

    def extent(self, view):
        """Start and length of a view in the binary chunk."""
        buffer = self.item(view, "buffer", "buffers")
        if "uri" in buffer or view["buffer"] != 0:
            raise InputError("buffers: expected one inside the file, found another file")
        start = _whole(view, "byteOffset", 0, len(self.binary), 0)
        return start, _whole(view, "byteLength", 1, len(self.binary) - start)

    def materials(self, primitives, triangle_counts):
        """The materials of the triangles, where there are eyes, and the pictures that are embedded."""
        kinds, extras = [], {}
        for primitive in primitives:
            material = self.item(primitive, "material", "materials") if "material" in primitive else {}
            kinds.append(Material.EYE if material.get("name") == MATERIAL_NAMES[Material.EYE] else Material.SKIN)
            image = self.image(material) if TEXTURE_FIELDS[kinds[-1]] not in extras else None
            if image is not None:
                extras[TEXTURE_FIELDS[kinds[-1]]] = image
        if Material.EYE in kinds:
            extras["materials"] = np.repeat(kinds, triangle_counts).astype(np.int32)
        return extras

    def image(self, material):
        """The picture (H,W,3) of a material's base colour, or None where none is embedded that can be read."""
        with suppress(InputError), tempfile.TemporaryDirectory() as folder:
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
            raise InputError(f"{shown(key, 40)}: expected the number of one of {len(items)} {container}, found another")
        return items[index]


def _dtype(holder):
    code = _whole(holder, "componentType", min(DTYPES), max(DTYPES))
    if code not in DTYPES:
        raise InputError(f"componentType: expected one of {[*DTYPES]}, found {code}")
    return DTYPES[code]


def _merged(sources, positions):
    """Where every distinct source first stands, (V,), and which of them every vertex is (M,)."""
    if not ((sources >= 0) & (sources < MAX_VERTICES) & (sources == np.floor(sources))).all():
        raise InputError(f"{SOURCE_VERTEX}: expected whole numbers from 0 to {MAX_VERTICES - 1}, found others")
    _, kept, place = np.unique(sources, return_index=True, return_inverse=True)
    if not np.allclose(positions, positions[kept][place], rtol=0, atol=_SAME_PLACE):
        raise InputError(f"{SOURCE_VERTEX}: expected one place for every number, found several")
    return kept, place
