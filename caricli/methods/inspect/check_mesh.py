"""How sound a mesh is."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.facing_out import facing_out
from caricli.geometry.repair.flat_triangles import flat_triangles
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.inspect.size_hint import size_hint
from caricli.structures import Mesh

_CLEARLY = 0.5
"""How far a surface faces inwards that is inside out; heads, masks and halves of heads face outwards by 0.6 to 1."""


@dataclass(frozen=True)
class MeshCheck:
    """What was found.

    vertices, polygons, triangles, uvs: numbers of them.
    height: in the unit of the file, which should be metres.
    hint: text where the height is no head's, else None.
    components: parts that no edge joins.
    open_edges: edges of one triangle only, as around a neck.
    unused: vertices in no triangle.
    degenerate: triangles without area.
    crowded: edges of more than two triangles.
    misoriented: edges whose two triangles are wound against each other.
    inside_out: whether nearly all of it faces inwards.
    flipped: triangles turned over against the head of the same topology, or None where there is none.
    """

    vertices: int
    polygons: int
    triangles: int
    uvs: int
    height: float
    hint: str | None
    components: int
    open_edges: int
    unused: int
    degenerate: int
    crowded: int
    misoriented: int
    inside_out: bool
    flipped: int | None

    @property
    def problems(self) -> list[str]:
        """What is not whole, in words."""
        counts = {
            "vertices in no triangle": self.unused,
            "triangles without area": self.degenerate,
            "edges of more than two triangles": self.crowded,
            "edges whose triangles are wound against each other": self.misoriented,
            "triangles turned over": self.flipped or 0,
        }
        problems = [f"{count} {words}" for words, count in counts.items() if count]
        return [*problems, *(["a surface inside out"] if self.inside_out else [])]


def check_mesh(mesh: Mesh, head: Mesh | None = None) -> MeshCheck:
    """Look at every vertex, edge and triangle of a mesh. head: Mesh that it may be a deformation of, or None."""
    faces = mesh.faces
    vertices = np.asarray(mesh.vertices, np.float64)
    count = len(vertices)
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, row, sharing = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    forwards = np.bincount(row.ravel(), directed[:, 0] < directed[:, 1], len(sharing))
    used = np.unique(faces)
    joined = sp.csr_matrix((np.ones(len(directed)), (directed[:, 0], directed[:, 1])), shape=(count, count))
    _, parts = connected_components(joined, directed=False)
    same = head is not None and head.topology_id == mesh.topology_id
    return MeshCheck(
        vertices=count,
        polygons=len(mesh.polygons),
        triangles=len(faces),
        uvs=0 if mesh.uvs is None else len(mesh.uvs),
        height=mesh.height,
        hint=size_hint(mesh.height),
        components=len(np.unique(parts[used])),
        open_edges=int((sharing == 1).sum()),
        unused=count - len(used),
        degenerate=int(flat_triangles(vertices, faces).sum()),
        crowded=int((sharing > 2).sum()),
        misoriented=int(((sharing == 2) & (forwards != 1)).sum()),
        inside_out=facing_out(vertices, faces, vertices[used].mean(0)) < -_CLEARLY,
        flipped=_flipped(vertices, head) if same and head is not None else None,
    )


def _flipped(vertices: np.ndarray, head: Mesh) -> int:
    return int(flipped_triangles(vertices, DeformationGradients(head.vertices, head.faces)).sum())
