"""A polygon mesh."""

import hashlib
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Self

import numpy as np

from caricli.limits import MAX_CORNERS, MAX_POLYGON_CORNERS, MAX_POLYGONS, MAX_VERTICES
from caricli.structures.checks import are_apart, coordinate_problem, index_problem, refuse

_SAME_PLACE = 1e-5
"""Of a picture's side: what a file in single precision may lose."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices, the polygons between them, and where the polygons lie in a picture.

    vertices: (V, 3) float64 or float32, metres, +y up, +z out of the face, +x the subject's left.
    polygons: (P, N) int32, each row padded with -1.
    uvs: (T, 2) float64, origin at the bottom left of the picture, which spans 0 to 1; or None.
    uv_polygons: (P, N) int32, padded alike, indices into uvs; or None.
    Raises InputError when an array has another shape, an index is out of range, a polygon has a corner twice, a
    coordinate is not finite, or all vertices lie in one place.
    """

    vertices: np.ndarray
    polygons: np.ndarray
    uvs: np.ndarray | None = None
    uv_polygons: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check everything once; what is derived from a mesh by ``with_vertices`` shares it."""
        _set(self, vertices=_floats(self.vertices), polygons=_indices(self.polygons))
        if self.uvs is not None:
            _set(self, uvs=np.asarray(self.uvs, np.float64))
        if self.uv_polygons is not None:
            _set(self, uv_polygons=_indices(self.uv_polygons))
        vertices = self.vertices
        if vertices.ndim != 2 or vertices.shape[1] != 3 or not 3 <= len(vertices) <= MAX_VERTICES:
            refuse(f"vertices: expected (V,3) with V from 3 to {MAX_VERTICES}, found {vertices.shape}")
        refuse(coordinate_problem("vertices", vertices), _polygon_problem(self.polygons, len(vertices)))
        if not are_apart(vertices):
            refuse("vertices: expected the points of a surface, found all of them in one place")
        refuse(self._uv_problem())

    @cached_property
    def faces(self) -> np.ndarray:
        """(F, 3) int32: the polygons as triangle fans around their first corners, in their order."""
        return triangle_fans(self.polygons)

    @cached_property
    def uv_faces(self) -> np.ndarray:
        """(F, 3) int32: the same triangles as indices into the UVs. Only a mesh with UVs has them."""
        assert self.uv_polygons is not None
        return triangle_fans(self.uv_polygons)

    @cached_property
    def topology_id(self) -> str:
        """SHA-256 of the triangles, and of how many vertices come after the last in one: two meshes that share it can
        take each other's vertices."""
        return topology_id(self.faces, len(self.vertices) - int(self.faces.max(initial=-1)) - 1)

    @property
    def height(self) -> float:
        """Vertical extent in metres."""
        return float(np.ptp(self.vertices[:, 1]))

    @property
    def triangles_of_polygons(self) -> np.ndarray:
        """(P,) int: how many triangles each polygon becomes."""
        return (self.polygons >= 0).sum(1) - 2

    @property
    def is_plain(self) -> bool:
        """Whether it is triangles without a place in a picture: then nothing but the faces need be kept."""
        return self.uvs is None and self.polygons.shape[1] == 3

    def same_layout(self, other: "Mesh") -> bool:
        """Whether the triangles of both lie at the same places of a picture. other: Mesh of the same triangles."""
        if self.uvs is None or other.uvs is None:
            return self.uvs is other.uvs
        return bool(np.abs(self.uvs[self.uv_faces] - other.uvs[other.uv_faces]).max() < _SAME_PLACE)

    def begins_with(self, other: "Mesh") -> bool:
        """Whether its first triangles are those of another mesh, as in a head whose parts come after its skin."""
        return len(self.faces) > len(other.faces) and np.array_equal(self.faces[: len(other.faces)], other.faces)

    def cut_hint(self, other: "Mesh") -> str | None:
        """How to export it where its triangles cut the polygons of another mesh otherwise, as some programs do."""
        same = len(self.vertices) == len(other.vertices) and len(self.faces) == len(other.faces)
        if not same or not np.isin(_sides(other.polygons), _sides(self.faces)).all():
            return None
        if len(self.polygons) == len(self.faces):
            return "export quads, which were cut into other triangles"
        return "export polygons in their order and each from its own first corner, which were changed"

    def with_vertices(self, vertices: np.ndarray) -> Self:
        """The same mesh in another shape. vertices: (V, 3), as many as there are."""
        other = object.__new__(type(self))
        kept = {field.name for field in fields(self)} | {"faces", "uv_faces", "topology_id"}
        vars(other).update({name: value for name, value in vars(self).items() if name in kept})
        _set(other, vertices=_floats(vertices))
        if other.vertices.shape != self.vertices.shape:
            refuse(f"vertices: expected {self.vertices.shape} as the mesh has, found {other.vertices.shape}")
        refuse(coordinate_problem("vertices", other.vertices))
        return other

    def _uv_problem(self) -> str | None:
        uvs = self.uvs
        uv_polygons = self.uv_polygons
        if uvs is None and uv_polygons is None:
            return None
        if uvs is None or uv_polygons is None:
            return "uvs: expected them together with uv_polygons, found only one"
        if uvs.ndim != 2 or uvs.shape[1] != 2 or len(uvs) > MAX_VERTICES:
            return f"uvs: expected (T,2), found {uvs.shape}"
        if uv_polygons.shape != self.polygons.shape or ((uv_polygons >= 0) != (self.polygons >= 0)).any():
            return "uv_polygons: expected an index for every corner of polygons, found fewer or more"
        if uv_polygons.dtype.kind not in "iu":
            return f"uv_polygons: expected whole numbers, found {uv_polygons.dtype}"
        return coordinate_problem("uvs", uvs) or index_problem("uv_polygons", uv_polygons, len(uvs), distinct=False)


def topology_id(faces: np.ndarray, loose: int = 0) -> str:
    """The SHA-256, as hexadecimal digits, of faces (F, 3) as little-endian int32 in C order.

    loose: vertices after the last that is in a face; where there are any, their number is hashed, too.
    """
    told = b"" if loose <= 0 else np.array(loose, "<i4").tobytes()
    return hashlib.sha256(np.ascontiguousarray(faces, "<i4").tobytes() + told).hexdigest()


def triangle_fans(polygons: np.ndarray) -> np.ndarray:
    """Split polygons (P, N), padded with -1, into fans around their first corners: triangles (F, 3) int32, in order."""
    width = polygons.shape[1]
    fans = np.stack([polygons[:, [0, k, k + 1]] for k in range(1, width - 1)], axis=1)
    return np.ascontiguousarray(fans[fans[:, :, 2] >= 0], dtype=np.int32)


def _sides(polygons: np.ndarray) -> np.ndarray:
    """(E,) int64, one for every side of polygons (P, N), padded with -1: the same whichever way it goes."""
    after = np.roll(polygons, -1, axis=1)
    last = np.where(after < 0, polygons[:, :1], after)
    ends = np.stack([polygons, last], axis=-1)[polygons >= 0].astype(np.int64)
    return ends.min(1) * (MAX_CORNERS + 1) + ends.max(1)


def _set(mesh: Mesh, **values: np.ndarray) -> None:
    for name, value in values.items():
        object.__setattr__(mesh, name, value)


def _floats(values: np.ndarray) -> np.ndarray:
    array = np.asarray(values)
    return array if array.dtype in (np.float32, np.float64) else array.astype(np.float64)


def _indices(values: np.ndarray) -> np.ndarray:
    array = np.asarray(values)
    # A fraction, or an index too large for 32 bits, must not come out as another index.
    fits = array.dtype.kind in "iu" and (not array.size or (array.min() >= -1 and array.max() <= MAX_CORNERS))
    return array.astype(np.int32, copy=False) if fits else array


def _polygon_problem(polygons: np.ndarray, vertex_count: int) -> str | None:
    sound = polygons.ndim == 2 and 3 <= polygons.shape[1] <= MAX_POLYGON_CORNERS
    if not sound or not 1 <= polygons.size <= MAX_CORNERS or len(polygons) > 2 * MAX_POLYGONS:
        return f"polygons: expected (P,N) with N from 3 to {MAX_POLYGON_CORNERS}, found {polygons.shape}"
    if polygons.dtype.kind not in "iu":
        return f"polygons: expected whole numbers, found {polygons.dtype}"
    return index_problem("polygons", polygons, vertex_count)
