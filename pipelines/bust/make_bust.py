"""Cut the shoulders that go under the bundled head out of its base mesh: python make_bust.py OUT.npz."""

import sys

import igl
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from caricli.io.npz import write_npz
from caricli.methods.parts.close_neck import neck_edge
from caricli.structures import Mesh
from caricli.template.extract_head import extract_body
from caricli.template.head import load_head

MIDDLE = -0.055
"""Metres, the height of the shoulders' joints: above it the cut goes straight up."""

WIDTH, DEPTH = 0.205, 0.15
"""Metres, half the cut's width and how far below its middle it goes: half an ellipse seen from the front."""

SNAP = 0.35
"""Of an edge: vertices that are no farther from the cut go onto it."""

END = 0.12
"""Where the cut lies in the picture, up from its lower end: below it is the plate."""


def main(path: str) -> None:
    """Write the bust as the package bundles it: its first vertices are those of the neck's edge, in their order."""
    template = load_head().template()
    edge = neck_edge(template)
    vertices, quads = extract_body()
    _, own = KDTree(vertices).query(template.vertices)
    body = _below(vertices, quads, own[template.polygons[(template.polygons >= 0).all(1)]])
    body = _clipped(vertices, body)
    mesh = _numbered(body, template.vertices[edge])
    loop = _loop(mesh, len(edge))
    uvs, uv_polygons = _layout(mesh, len(edge), loop)
    skin = Mesh(mesh.vertices, mesh.polygons, uvs, uv_polygons)
    whole = _closed(skin, loop)
    assert whole.uvs is not None and whole.uv_polygons is not None
    arrays = {"edge": edge, "vertices": whole.vertices, "polygons": whole.polygons.astype(np.int32)}
    write_npz(path, arrays | {"uvs": whole.uvs.astype(np.float32), "uv_polygons": whole.uv_polygons.astype(np.int32)})


def _height(places: np.ndarray) -> np.ndarray:
    """How far outside the cut places (N, 3) are: below zero inside."""
    below = np.minimum(places[:, 1] - MIDDLE, 0)
    return np.hypot(places[:, 0] / WIDTH, below / DEPTH) - 1


def _below(vertices: np.ndarray, quads: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Quads of the body's skin that are not of the head."""
    keys = {tuple(sorted(quad)) for quad in head.tolist()}
    rest = quads[[tuple(sorted(quad)) not in keys for quad in quads.tolist()]]
    pairs = np.concatenate([rest[:, [k, (k + 1) % 4]] for k in range(4)])
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(vertices),) * 2)
    _, piece = connected_components(graph, directed=False)
    on_edge = np.intersect1d(rest, head)
    return rest[piece[rest[:, 0]] == np.bincount(piece[on_edge]).argmax()]


def _clipped(vertices: np.ndarray, quads: np.ndarray) -> Mesh:
    """The quads as far as they are inside the cut."""
    vertices = vertices.copy()
    height = _height(vertices)
    pairs = np.unique(np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1), axis=0)
    for a, b in pairs:
        for one, other in ((a, b), (b, a)):
            if height[one] * height[other] < 0 and height[one] / (height[one] - height[other]) < SNAP:
                vertices[one] = _crossing(vertices[one], vertices[other])
                height[one] = 0.0
    places = list(vertices)
    between: dict[tuple[int, int], int] = {}
    polygons = []
    for quad in quads:
        corners = []
        for a, b in zip(quad, np.roll(quad, -1), strict=True):
            if height[a] <= 0:
                corners.append(int(a))
            if height[a] * height[b] < 0:
                key = (min(a, b), max(a, b))
                if key not in between:
                    between[key] = len(places)
                    places.append(_crossing(vertices[a], vertices[b]))
                corners.append(between[key])
        if (height[quad] < 0).any():
            polygons += [corners] if len(corners) < 5 else [corners[:4], [corners[0], *corners[3:]]]
    return Mesh(np.array(places), np.array([p + [-1] * (4 - len(p)) for p in polygons], np.int32))


def _crossing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Where the way between two places crosses the cut."""
    low, high = (one, other) if _height(one[None])[0] < 0 else (other, one)
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if _height(middle[None])[0] < 0 else (low, middle)
    return (low + high) / 2


def _numbered(mesh: Mesh, rim: np.ndarray) -> Mesh:
    """The mesh without vertices that it does not use, those at the rim (L, 3) first, connected to it."""
    used = np.unique(mesh.polygons[mesh.polygons >= 0])
    _, first = KDTree(mesh.vertices[used]).query(rim)
    order = np.concatenate([used[first], np.setdiff1d(used, used[first])])
    number = np.full(len(mesh.vertices) + 1, -1, np.int32)
    number[order] = np.arange(len(order))
    vertices = mesh.vertices[order]
    vertices[: len(rim)] = rim
    return Mesh(vertices, number[mesh.polygons])


def _loop(mesh: Mesh, around: int) -> np.ndarray:
    """Vertices along the cut, from the middle of the back, in the order of the rim."""
    loops = [np.asarray(loop) for loop in igl.boundary_loop_all(mesh.faces.astype(np.int64))]
    assert len(loops) == 2, [len(loop) for loop in loops]
    loop = next(loop for loop in loops if loop.min() >= around)
    middle = loop[np.abs(mesh.vertices[loop, 0]) < 1e-6]
    loop = np.roll(loop, -int(np.nonzero(loop == middle[np.argmin(mesh.vertices[middle, 2])])[0][0]))
    side = mesh.vertices[loop[len(loop) // 4], 0] * mesh.vertices[around // 4, 0]
    return loop if side > 0 else np.append(loop[:1], loop[:0:-1])


def _layout(mesh: Mesh, around: int, loop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """UVs and their polygons: u once around from the middle of the back, v from 1 at the rim to END at the cut."""
    polygons = mesh.polygons
    used = polygons >= 0
    back = (np.abs(mesh.vertices[:, 0]) < 1e-6) & (mesh.vertices[:, 2] < mesh.vertices[:around, 2].mean())
    centre = np.where(used, mesh.vertices[polygons, 0], 0).sum(1)
    # The rim begins towards one side; on the other the seam's vertices get a copy.
    late = (centre * mesh.vertices[1, 0] < 0)[:, None] & used & back[polygons]
    copy = np.full(len(mesh.vertices), -1)
    copy[back] = len(mesh.vertices) + np.arange(back.sum())
    uv_polygons = np.where(late, copy[polygons], polygons).astype(np.int32)
    cut = Mesh(np.vstack([mesh.vertices, mesh.vertices[back]]), uv_polygons)
    fixed_u = {int(k): k / around for k in range(around)} | {int(copy[0]): 1.0}
    fixed_u |= {int(k): 0.0 for k in np.nonzero(back)[0]} | {int(copy[k]): 1.0 for k in np.nonzero(back)[0]}
    step = np.linalg.norm(np.diff(mesh.vertices[np.append(loop, loop[0])], axis=0), axis=1)
    share = np.append(0, np.cumsum(step))[:-1] / step.sum()
    fixed_u |= {int(k): s for k, s in zip(loop, share, strict=True)}
    fixed_v = {int(k): 1.0 for k in [*range(around), copy[0]]}
    fixed_v |= {int(k): END for k in [*loop, copy[loop[0]]]}
    return np.stack([_harmonic(cut, fixed) for fixed in (fixed_u, fixed_v)], -1), uv_polygons


def _harmonic(mesh: Mesh, fixed: dict[int, float]) -> np.ndarray:
    """(V,) the smoothest function with these values."""
    b = np.array(list(fixed), np.int64)
    values = np.array(list(fixed.values()))[:, None]
    return np.asarray(igl.harmonic(mesh.vertices, mesh.faces.astype(np.int64), b, values, 1)).ravel()


def _closed(mesh: Mesh, loop: np.ndarray) -> Mesh:
    """The mesh with a plate along the cut, on vertices and in a stripe of the picture of its own."""
    assert mesh.uvs is not None and mesh.uv_polygons is not None
    places = mesh.vertices[loop]
    angle = np.arctan2(places[:, 0] / WIDTH, np.maximum(MIDDLE - places[:, 1], 0) / DEPTH)
    along = angle + np.sign(places[:, 0]) * np.maximum(places[:, 1] - MIDDLE, 0) / DEPTH
    plate = _strip(along)
    ways = {way for face in mesh.faces.tolist() for way in zip(face, face[1:] + face[:1], strict=True)}
    # Each edge is gone along once each way.
    if ((loop[0], loop[1]) in ways) == (((plate == 0) & (np.roll(plate, -1, 1) == 1)).any()):
        plate = plate[:, ::-1]
    size = places.max(0) - places.min(0)
    u = (along - along.min()) / np.ptp(along)
    v = 0.9 * END * (places[:, 2] - places[:, 2].min()) / size[2]
    pad = np.full((len(plate), 1), -1)
    return Mesh(
        np.vstack([mesh.vertices, places]),
        np.vstack([mesh.polygons, np.hstack([plate + len(mesh.vertices), pad])]),
        np.vstack([mesh.uvs, np.stack([u, v], -1)]),
        np.vstack([mesh.uv_polygons, np.hstack([plate + len(mesh.uvs), pad])]),
    )


def _strip(along: np.ndarray) -> np.ndarray:
    """(F, 3) triangles between front and back of a loop. along: (N,) how far from one end to the other places are."""
    count = len(along)
    first = int(np.argmin(along))
    one = [first]
    while one[-1] != int(np.argmax(along)):
        one.append((one[-1] + 1) % count)
    other = [first, *((first - k) % count for k in range(1, count - len(one) + 1)), one[-1]]
    faces = []
    i = 0
    j = 0
    while i < len(one) - 1 or j < len(other) - 1:
        ahead = j == len(other) - 1 or (i < len(one) - 1 and along[one[i + 1]] <= along[other[j + 1]])
        faces.append([one[i], other[j], one[i + 1] if ahead else other[j + 1]])
        i += int(ahead)
        j += int(not ahead)
    # At both ends the sides are one.
    whole = [len(set(face)) == 3 for face in faces]
    return np.array(faces)[whole]


if __name__ == "__main__":
    main(sys.argv[1])
