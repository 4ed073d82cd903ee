"""Rigs to GLB: one mesh with named morph targets."""

import io
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from caricli import __version__
from caricli.errors import OutputError, shown
from caricli.io.gltf.format import (
    BINARY_CHUNK,
    CHUNK,
    DTYPES,
    HEADER,
    JSON_CHUNK,
    MAGIC,
    MATERIAL_NAMES,
    SOURCE_VERTEX,
    TYPES,
    VERSION,
)
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json
from caricli.limits import MAX_FILE_BYTES
from caricli.structures import Animation, Material, Rig

_COLOURS = {Material.SKIN: [0.7, 0.42, 0.3, 1], Material.EYE: [0.85, 0.83, 0.8, 1]}
_ROUGHNESS = 0.6
_CODES = {dtype: code for code, dtype in DTYPES.items()}
_FOR_VERTICES, _FOR_INDICES = 34962, 34963
_LINEAR, _LINEAR_MIPMAP_LINEAR = 9729, 9987


def write_gltf(path: Path, rig: Rig, sparse: bool = False, animation: Animation | None = None) -> None:
    """Write a rig as GLB: metres, +y up, +z front; the same rig gives the same bytes.

    One node with one mesh; one primitive for every material; morph targets of positions and normals, their names in
    ``mesh.extras.targetNames``. Vertices are split where the UVs have a seam, and `SOURCE_VERTEX` leads back; those of
    no polygon stand at the end of the first primitive.
    Parameters: path; rig, Rig; sparse, whether of a target only the vertices that move are stored; animation, Animation
    or None.
    Raises: OutputError when the rig could not be read back, the animation does not fit it, or the file cannot be
    written.
    """
    if animation is not None and np.shape(animation.weights)[1] != len(rig.names):
        found = np.shape(animation.weights)[1]
        raise OutputError(f"{shown(path)}: expected weights of the rig's {len(rig.names)} expressions, found {found}")
    buffer = _Buffer()
    document = {
        "asset": {"version": f"{VERSION}.0", "generator": f"caricli {__version__}"},
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
    length = HEADER.size + 2 * CHUNK.size + len(text) + len(binary)
    if length > MAX_FILE_BYTES:
        raise OutputError(f"{shown(path)}: expected at most {MAX_FILE_BYTES} bytes of GLB, found {length}")
    start = HEADER.pack(MAGIC, VERSION, length) + CHUNK.pack(len(text), JSON_CHUNK)
    write_bytes(path, start + text + CHUNK.pack(len(binary), BINARY_CHUNK) + binary)


def shading_normals(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """Area-weighted unit normals of the neutral, and what every shape adds to them.

    Returns (V,3) and (K,V,3) float32; +z where a vertex has no triangle with an area; what is added is zero where no
    neighbour moves.
    """
    neutral, triangles = np.asarray(rig.neutral, np.float64), rig.mesh.faces
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
        accessor = {"componentType": _CODES[array.dtype], "count": len(rows), "type": TYPES[rows.shape[1]]}
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
    mesh = rig.mesh
    triangles = mesh.faces
    materials = rig.triangle_materials
    corners, uvs = (mesh.uv_faces, mesh.uvs) if mesh.uvs is not None else (np.zeros_like(triangles), np.zeros((1, 2)))
    neutral, deltas = (np.asarray(a, np.float32) for a in (rig.neutral, rig.deltas))
    normals, normal_deltas = shading_normals(rig)
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
        if mesh.uvs is not None:
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


def _materials(rig, buffer):
    """The materials in the order of the primitives, with their pictures."""
    materials, images = [], []
    for material in np.unique(rig.triangle_materials).tolist():
        surface = {"metallicFactor": 0, "roughnessFactor": _ROUGHNESS}
        image = rig.picture(material)
        # A picture without UVs has no place on the surface.
        if image is None or rig.mesh.uvs is None:
            surface["baseColorFactor"] = _COLOURS[material]
        else:
            surface["baseColorTexture"] = {"index": len(images)}
            images.append({"mimeType": "image/png", "bufferView": buffer.view(_png(image))})
        materials.append({"name": MATERIAL_NAMES[material], "pbrMetallicRoughness": surface})
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
