"""GLB and glTF files to rigs or meshes, ours or another program's; nothing in them is trusted."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.gltf.changes import changes_of
from caricli.io.gltf.container import read_container
from caricli.io.gltf.document import Document
from caricli.io.gltf.format import SOURCE_VERTEX
from caricli.io.gltf.materials import Placing, kind_of, material_of, picture_of, placing_of
from caricli.io.gltf.rig_parts import RigPart, primitives_of, rig_parts
from caricli.io.gltf.scene import node_placements
from caricli.io.gltf.variants import moods_of
from caricli.io.strict_json import take, take_whole
from caricli.limits import MAX_CORNERS, MAX_NPZ_BYTES, MAX_VERTICES
from caricli.structures import Material, Mesh, Pictures, Rig
from caricli.structures.pictures import PICTURED

_TRIANGLES = 4
# What these extensions change is how things look, never where vertices are.
_HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")
_SAME_PLACE = 1e-5


def read_gltf(path: str | Path) -> Rig:
    """Read the mesh with most morph targets of a GLB, or where none has any the first one, ours or another program's.

    What ``rig_parts`` says belongs to it comes along. Vertices with the same `SOURCE_VERTEX` become one again. Its node
    and those above it turn, scale and mirror it, but for what an animation moves. Of the materials the base colour's
    picture is read, where it is embedded; UVs are those that it lies by. Materials named as ours say what they are of.
    Variants of the skin's material, with pictures as large as its own, are moods; its changes are read. Skins,
    animations and weights are left aside.
    path: a GLB file, or a .gltf, without external files.
    Returns a Rig of triangles; polygons only beside UVs or materials.
    Raises InputError when it is malformed, compressed, has no mesh or is beyond the caps.
    """
    content, buffers = read_container(path)
    with naming(path):
        document = Document(content, buffers)
        _refuse_extensions(document)
        names, parts, _ = rig_parts(document)
        return _rig(document, names, parts)


def read_gltf_mesh(path: str | Path) -> Mesh:
    """Read the neutral mesh of a rig or of a head of ours, else all meshes of the scene where their nodes put them.

    path: a GLB file, or a .gltf, without external files.
    Returns a Mesh of triangles, float64, with UVs where all its parts have them.
    Raises InputError when it is malformed, compressed, names other files, has no mesh or is beyond the caps.
    """
    content, buffers = read_container(path)
    with naming(path):
        document = Document(content, buffers)
        _refuse_extensions(document)
        _refuse_other_files(document)
        names, parts, is_ours = rig_parts(document)
        if is_ours or names:
            neutral = _rig(document, names, parts).mesh
            return neutral.with_vertices(neutral.vertices.astype(np.float64))
        return _scene_mesh(document)


@dataclass(frozen=True)
class _Block:
    """Vertices that one or more primitives share: their accessors, those of their targets, how many they are, where
    they lie in the picture, and the transform (4,4) that puts them into place."""

    attributes: dict
    targets: list[dict]
    count: int
    placing: Placing
    placement: np.ndarray

    def positions(self, document: Document) -> np.ndarray:
        """Vertices (V,3), float32."""
        own = document.floats(self.attributes, "POSITION", 3, self.count)
        return _stood(own, self.placement, self.placement[:3, 3])

    def displacements(self, document: Document, target: int) -> np.ndarray:
        """What a target does to them, (V,3) float32."""
        return _stood(document.floats(self.targets[target], "POSITION", 3, self.count), self.placement)

    def uvs(self, document: Document) -> np.ndarray:
        """Places in the picture (V,2), origin at the bottom left."""
        return self.placing.uvs(document.floats(self.attributes, self.placing.key, 2, self.count))


@dataclass(frozen=True)
class _Surface:
    """The blocks of vertices of some primitives, and the triangles (F,3) of each primitive, counted through them."""

    blocks: list[_Block]
    triangles: list[np.ndarray]

    def has(self, key: str) -> bool:
        """Whether all vertices have an attribute."""
        return all(key in block.attributes for block in self.blocks)

    def attribute(self, document: Document, key: str, width: int) -> np.ndarray:
        """An attribute of all vertices, (V,W) float32."""
        parts = [document.floats(block.attributes, key, width, block.count) for block in self.blocks]
        return np.concatenate(parts)

    def positions(self, document: Document) -> np.ndarray:
        """All vertices, (V,3) float32."""
        return np.concatenate([block.positions(document) for block in self.blocks])

    def displacements(self, document: Document, target: int) -> np.ndarray:
        """What a target does to all vertices, (V,3) float32."""
        return np.concatenate([block.displacements(document, target) for block in self.blocks])

    def uvs(self, document: Document) -> np.ndarray | None:
        """Places in the picture (V,2), origin at the bottom left, or None where a vertex has none."""
        if not all(block.placing.key in block.attributes for block in self.blocks):
            return None
        return np.concatenate([block.uvs(document) for block in self.blocks])


def _refuse_extensions(document: Document) -> None:
    for name in take(document.content, "extensionsRequired", list, []):
        if not isinstance(name, str) or not name.startswith(_HARMLESS):
            raise InputError(f"expected plain glTF, found the extension {shown(name, 60)}")


def _refuse_other_files(document: Document) -> None:
    for key in ("buffers", "images"):
        for entry in take(document.content, key, list, []):
            uri = entry.get("uri") if isinstance(entry, dict) else None
            if uri is not None and not (isinstance(uri, str) and uri.startswith("data:")):
                raise InputError(f"{key}: expected one inside the file, found another file: {shown(uri, 60)!r}")


def _rig(document: Document, names: tuple[str, ...], parts: list[RigPart]) -> Rig:
    surface = _surface(document, parts, len(names))
    positions = surface.positions(document)
    kept = np.arange(len(positions))
    place = kept
    if surface.has(SOURCE_VERTEX):
        kept, place = _merged(surface.attribute(document, SOURCE_VERTEX, 1)[:, 0], positions)
    deltas = np.empty((len(names), len(kept), 3), np.float32)
    for k, delta in enumerate(deltas):
        delta[:] = surface.displacements(document, k)[kept]
    triangles = np.concatenate(surface.triangles)
    uvs = surface.uvs(document)
    uv_faces = None if uvs is None else triangles.astype(np.int32)
    neutral = Mesh(positions[kept], place[triangles].astype(np.int32), uvs, uv_faces)
    return Rig(names, neutral, deltas, **_looks(document, [part.primitive for part in parts], surface))


def _stood(vectors: np.ndarray, placement: np.ndarray, shift: np.ndarray | float = 0.0) -> np.ndarray:
    """Vectors (V,3) turned by a transform (4,4) and then moved by a shift (3,), float32; themselves, to the bit, where
    that changes nothing."""
    if np.array_equal(placement[:3, :3], np.eye(3)) and not np.any(shift):
        return vectors
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it no mesh takes
        return (vectors @ placement[:3, :3].T + shift).astype(np.float32)


def _surface(document: Document, parts: list[RigPart], shape_count: int) -> _Surface:
    """The surface of primitives; those that share their vertices, place and UVs share a block."""
    blocks: list[_Block] = []
    starts: dict[str, int] = {}
    triangles: list[np.ndarray] = []
    total = 0
    triangle_count = 0
    for part in parts:
        block = _block(document, part)
        key = repr((block.attributes, block.targets, block.placing, part.placement.tolist()))
        if key not in starts:
            starts[key] = total
            total += block.count
            blocks.append(block)
            if total > MAX_VERTICES or total * shape_count * 12 > MAX_NPZ_BYTES:
                expected = f"at most {MAX_VERTICES} vertices and {MAX_NPZ_BYTES} bytes of displacements"
                raise InputError(f"expected {expected}, found {total} vertices and {shape_count} targets")
        own = _primitive_triangles(document, part.primitive, block.count)
        triangles.append(starts[key] + _outwards(own, part.placement))
        triangle_count += len(triangles[-1])
        if triangle_count > MAX_CORNERS // 3:
            raise InputError(f"expected at most {MAX_CORNERS // 3} triangles, found more")
    return _Surface(blocks, triangles)


def _block(document: Document, part: RigPart) -> _Block:
    attributes = take(part.primitive, "attributes", dict)
    targets = part.primitive["targets"]
    if not all(isinstance(target, dict) for target in targets):
        raise InputError("targets: expected objects, found others")
    count = take_whole(document.item(attributes, "POSITION", "accessors"), "count", 1, MAX_VERTICES)
    placing = placing_of(material_of(document, part.primitive))
    return _Block(attributes, targets, count, placing, part.placement)


def _primitive_triangles(document: Document, primitive: dict, count: int) -> np.ndarray:
    """The triangles (F,3) of a primitive of so many vertices."""
    mode = primitive.get("mode", _TRIANGLES)
    if mode != _TRIANGLES:
        raise InputError(f"mode: expected triangles ({_TRIANGLES}), found {shown(mode, 40)}")
    indices = np.arange(count)
    if "indices" in primitive:
        indices = document.accessor(document.item(primitive, "indices", "accessors"), 1)[:, 0]
    if indices.dtype.kind == "f" or len(indices) % 3 or indices.max() >= count:
        raise InputError(f"indices: expected three whole numbers below {count} for every triangle, found others")
    return indices.astype(np.int64).reshape(-1, 3)


def _merged(sources: np.ndarray, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where every distinct source first stands, (V,), and which of them every vertex is (M,)."""
    if not ((sources >= 0) & (sources < MAX_VERTICES) & (sources == np.floor(sources))).all():
        raise InputError(f"{SOURCE_VERTEX}: expected whole numbers from 0 to {MAX_VERTICES - 1}, found others")
    _, kept, place = np.unique(sources, return_index=True, return_inverse=True)
    if not np.allclose(positions, positions[kept][place], rtol=0, atol=_SAME_PLACE):
        raise InputError(f"{SOURCE_VERTEX}: expected one place for every number, found several")
    return kept, place


def _looks(document: Document, primitives: list[dict], surface: _Surface) -> dict:
    """The materials of the triangles, where not all is skin, and the pictures that are embedded."""
    kinds: list[Material] = []
    pictures: dict[str, np.ndarray] = {}
    painted: dict[str, dict] = {}
    for primitive in primitives:
        material = material_of(document, primitive)
        kinds.append(kind_of(material))
        name = PICTURED.get(kinds[-1])
        image = None if name is None or name in pictures else picture_of(document, material)
        if name is not None and image is not None:
            pictures[name] = image
            painted[name] = primitive
    looks: dict = {"pictures": Pictures(**pictures)}
    if "skin" in pictures:
        skin = painted["skin"]
        moods = moods_of(document, skin, partial(picture_of, document))
        material = document.item(skin, "material", "materials")
        looks["changes"] = changes_of(document, material, len(skin["targets"]), partial(picture_of, document))
        looks["moods"] = tuple(mood for mood in moods if mood.skin.shape == pictures["skin"].shape)
    if any(kind != Material.SKIN for kind in kinds):
        looks["materials"] = np.repeat(kinds, [len(part) for part in surface.triangles]).astype(np.int32)
    return looks


def _scene_mesh(document: Document) -> Mesh:
    """All meshes of the scene as one, each as often as a node shows it."""
    vertices: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    uvs: list[np.ndarray | None] = []
    count = 0
    triangle_count = 0
    for surface, placement in _surfaces(document):
        positions = surface.attribute(document, "POSITION", 3).astype(np.float64)
        triangles = count + np.concatenate(surface.triangles)
        count += len(positions)
        triangle_count += len(triangles)
        with np.errstate(over="ignore", invalid="ignore"):  # what comes of it no mesh takes
            vertices.append(positions @ placement[:3, :3].T + placement[:3, 3])
        faces.append(_outwards(triangles, placement))
        uvs.append(surface.uvs(document))
        if count > MAX_VERTICES or triangle_count > MAX_CORNERS // 3:
            expected = f"at most {MAX_VERTICES} vertices and {MAX_CORNERS // 3} triangles in the scene"
            raise InputError(f"expected {expected}, found more")
    all_faces = np.concatenate(faces)
    places = [part for part in uvs if part is not None]
    if len(places) < len(uvs):
        return Mesh(np.concatenate(vertices), all_faces)
    return Mesh(np.concatenate(vertices), all_faces, np.concatenate(places), all_faces)


def _outwards(triangles: np.ndarray, placement: np.ndarray) -> np.ndarray:
    """Triangles (F,3) after a transform (3,3) or (4,4): a mirror turns them inside out."""
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it no mesh takes
        is_mirror = np.linalg.det(placement[:3, :3]) < 0
    return triangles[:, ::-1] if is_mirror else triangles


def _surfaces(document: Document) -> Iterator[tuple[_Surface, np.ndarray]]:
    """The surfaces of the nodes that have a mesh, and where the nodes put them (4,4)."""
    shown_any = False
    for mesh, placement in node_placements(document):
        parts = [RigPart(primitive | {"targets": []}, np.eye(4)) for primitive in primitives_of(mesh)]
        if parts:
            shown_any = True
            yield _surface(document, parts, 0), placement
    if not shown_any:
        raise InputError("expected a mesh in the scene, found none")
