"""Rigs to GLB or glTF: one mesh with named morph targets."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from caricli import __version__
from caricli.errors import OutputError, shown
from caricli.geometry.comb_hair import comb_hair
from caricli.geometry.mouth_light import mouth_light
from caricli.io.gltf.changes import add_changes
from caricli.io.gltf.container import write_container
from caricli.io.gltf.format import DTYPES, SOURCE_VERTEX, TYPES, VERSION
from caricli.io.gltf.strands import add_strands, has_strands, strand_tangents
from caricli.io.gltf.variants import add_variants
from caricli.io.image import png_bytes
from caricli.structures import Animation, Rig
from caricli.structures.materials import IN_MOUTH, Material

_CODES = {dtype: code for code, dtype in DTYPES.items()}
_FOR_VERTICES = 34962
_FOR_INDICES = 34963
_LINEAR = 9729
_LINEAR_MIPMAP_LINEAR = 9987


def write_gltf(path: str | Path, rig: Rig, sparse: bool = False, animation: Animation | None = None) -> None:
    """Write a rig: metres, +y up, +z front; the same rig gives the same bytes.

    One node with one mesh; one primitive for every material; morph targets of positions and normals, their names in
    ``mesh.extras.targetNames``; targets that move nothing share their zeros. Teeth and tongue have colours of vertices
    (`mouth_light`). Hair that keeps still is a node of its own below the head's; where it has a picture it shines
    across its strands (`add_strands`). Moods are variants of the skin's material (`add_variants`), changes a texture
    beside it (`add_changes`). Vertices are split where the UVs have a seam, and `SOURCE_VERTEX` leads back; those of no
    polygon stand at the end of the first primitive.
    path: a GLB, or, where it ends in .gltf, one text with all inside. sparse: whether of a target only the vertices
    that move are stored. animation: weights of the rig's shapes over time, or None.
    Raises OutputError when the animation does not fit the rig, the file would be larger than what is read, or it
    cannot be written.
    """
    if animation is not None and np.shape(animation.weights)[1] != len(rig.names):
        count = np.shape(animation.weights)[1]
        raise OutputError(f"{shown(path)}: expected weights of the rig's {len(rig.names)} expressions, found {count}")
    buffer = _Buffer()
    document: dict = {
        "asset": {"version": f"{VERSION}.0", "generator": f"caricli {__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        **_nodes(rig, _primitives(rig, sparse, buffer)),
        **_materials(rig, buffer),
    }
    if rig.pictures.skin is not None and rig.mesh.uvs is not None and (rig.triangle_materials == Material.SKIN).any():
        _add_expressions(document, rig, buffer)
    if has_strands(rig):
        add_strands(document, np.unique(rig.triangle_materials).tolist().index(Material.HAIR))
    if animation is not None and (rig.names or animation.rotations is not None):
        document["animations"] = [_animation(animation, buffer)]
    document |= {"accessors": buffer.accessors, "bufferViews": buffer.views}
    write_container(path, document, b"".join(buffer.parts))


def _add_expressions(document: dict, rig: Rig, buffer: "_Buffer") -> None:
    """Add what a rig has of its skin in expressions: moods and changes."""
    # The skin is the first of the materials, and of the primitives.
    if rig.moods:
        add_variants(document, document["meshes"][0]["primitives"][0], rig.moods, buffer.view)
    if rig.changes is not None:
        add_changes(document, document["materials"][0], rig.changes, buffer.view)


def shading_normals(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """Area-weighted unit normals of the neutral, hair combed (`comb_hair`), and what every shape adds to them.

    Returns (V,3) and (K,V,3) float32; +z where a vertex has no triangle with an area; what is added is zero where no
    neighbour moves.
    """
    neutral = np.asarray(rig.neutral, np.float64)
    triangles = rig.mesh.faces
    places = (triangles.ravel(), np.repeat(np.arange(len(triangles)), 3))
    around = sp.csr_matrix((np.ones(triangles.size), places), shape=(len(neutral), len(triangles)))

    def normals(vertices: np.ndarray) -> np.ndarray:
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        total = around @ np.cross(b - a, c - a)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.where(length > 0, total / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])

    still = normals(neutral)
    added = np.empty(np.shape(rig.deltas), np.float32)
    for k, delta in enumerate(rig.deltas):
        added[k] = normals(neutral + delta) - still
    materials = rig.triangle_materials
    hair = comb_hair(neutral, triangles, still, materials == Material.HAIR, materials == Material.SKIN)
    return (still if hair is None else hair.normals(still)).astype(np.float32), added


class _Buffer:
    """The binary chunk as it grows, with the views and accessors of its parts."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.views: list[dict] = []
        self.accessors: list[dict] = []
        self._length = 0
        self._zeros: dict[int, int] = {}

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes, padded to a multiple of four; returns the number of the view."""
        padding = bytes(-len(data) % 4)
        view = {"buffer": 0, "byteOffset": self._length, "byteLength": len(data)}
        self.views.append(view if target is None else view | {"target": target})
        self.parts += [data, padding]
        self._length += len(data) + len(padding)
        return len(self.views) - 1

    def accessor(self, array: np.ndarray, target: int | None = None, bounds: bool = False, sparse: bool = False) -> int:
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

    def displacements(self, array: np.ndarray, sparse: bool) -> int:
        """Append displacements (N,3); those that are all zero are there once."""
        if array.any():
            return self.accessor(array, None if sparse else _FOR_VERTICES, bounds=True, sparse=sparse)
        if len(array) not in self._zeros:
            target = None if sparse else _FOR_VERTICES
            self._zeros[len(array)] = self.accessor(array, target, bounds=True, sparse=sparse)
        return self._zeros[len(array)]


def _index_dtype(count: int) -> np.dtype:
    # The largest number of a type is the mark of a restart and no index.
    return np.dtype("<u2") if count <= np.iinfo(np.uint16).max else np.dtype("<u4")


def _nodes(rig: Rig, primitives: list[dict]) -> dict[str, list[dict]]:
    """The head, and where it has hair that keeps still, this as its child."""
    apart = _hair_apart(rig)
    kinds = np.unique(rig.triangle_materials)
    own = [
        primitive for primitive, kind in zip(primitives, kinds, strict=True) if not (apart and kind == Material.HAIR)
    ]
    node: dict[str, object] = {"name": "head", "mesh": 0}
    mesh: dict[str, object] = {"name": "head", "primitives": own}
    if rig.names:
        mesh |= {"weights": [0] * len(rig.names), "extras": {"targetNames": list(rig.names)}}
    if not apart:
        return {"nodes": [node], "meshes": [mesh]}
    hair = [primitive for primitive in primitives if primitive not in own]
    nodes = [node | {"children": [1]}, {"name": "hair", "mesh": 1}]
    return {"nodes": nodes, "meshes": [mesh, {"name": "hair", "primitives": hair}]}


def _hair_apart(rig: Rig) -> bool:
    """Whether there is hair that keeps still on something else."""
    hair = rig.triangle_materials == Material.HAIR
    return bool(hair.any() and not hair.all() and not np.any(rig.deltas[:, np.unique(rig.faces[hair])]))


def _primitives(rig: Rig, sparse: bool, buffer: _Buffer) -> list[dict]:
    """One primitive for every material."""
    triangles = rig.mesh.faces
    materials = rig.triangle_materials
    uvs = rig.mesh.uvs if rig.mesh.uvs is not None else np.zeros((1, 2))
    corners = rig.mesh.uv_faces if rig.mesh.uvs is not None else np.zeros_like(triangles)
    neutral = np.asarray(rig.neutral, np.float32)
    normals, normal_deltas = shading_normals(rig)
    light = mouth_light(neutral, rig.faces, rig.triangle_materials, rig.pictures.coloured)
    keys = triangles.astype(np.int64) * len(uvs) + corners
    loose = np.setdiff1d(np.arange(len(neutral)), triangles) * len(uvs)
    apart = _hair_apart(rig)
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
        if rig.mesh.uvs is not None:
            # glTF counts v from the top.
            flipped = np.stack([uvs[corner, 0], 1 - uvs[corner, 1]], axis=1).astype(np.float32)
            attributes["TEXCOORD_0"] = buffer.accessor(flipped, _FOR_VERTICES)
        if material == Material.HAIR and has_strands(rig):
            tangents = strand_tangents(rig.mesh, materials == Material.HAIR, normals)
            attributes["TANGENT"] = buffer.accessor(tangents[source], _FOR_VERTICES)
        if material in IN_MOUTH:
            attributes["COLOR_0"] = buffer.accessor(light[source], _FOR_VERTICES)
        indices = indices.ravel().astype(_index_dtype(len(source)))
        primitive = {"attributes": attributes, "indices": buffer.accessor(indices, _FOR_INDICES), "material": number}
        deltas = np.asarray(rig.deltas, np.float32)[:, source]
        if rig.names and not (apart and material == Material.HAIR):
            primitive["targets"] = [
                {"POSITION": buffer.displacements(delta, sparse), "NORMAL": buffer.displacements(normal, sparse)}
                for delta, normal in zip(deltas, normal_deltas[:, source], strict=True)
            ]
        primitives.append(primitive)
    return primitives


def _materials(rig: Rig, buffer: _Buffer) -> dict[str, list[dict]]:
    """The materials in the order of the primitives, with their pictures."""
    materials: list[dict] = []
    images: list[dict] = []
    for number in np.unique(rig.triangle_materials).tolist():
        material = Material(number)
        finish = rig.pictures.finish(material)
        surface: dict = {"metallicFactor": 0, "roughnessFactor": finish.roughness}
        image = rig.pictures.of(material)
        # A picture without UVs has no place on the surface.
        if image is None or rig.mesh.uvs is None:
            surface["baseColorFactor"] = [*finish.linear, 1]
        else:
            surface["baseColorTexture"] = {"index": len(images)}
            images.append({"name": finish.name, "mimeType": "image/png", "bufferView": buffer.view(png_bytes(image))})
        # A shell of hair has an inside, which is seen from below.
        sides = {"doubleSided": True} if material == Material.HAIR else {}
        materials.append({"name": finish.name, "pbrMetallicRoughness": surface, **sides})
    if not images:
        return {"materials": materials}
    return {
        "materials": materials,
        "textures": [{"sampler": 0, "source": k} for k in range(len(images))],
        "images": images,
        "samplers": [{"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP_LINEAR}],
    }


def _animation(animation: Animation, buffer: _Buffer) -> dict:
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
