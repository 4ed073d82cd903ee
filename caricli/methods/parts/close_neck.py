"""What closes the open neck of a head."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import cv2
import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.lines.rows_at import rows_at
from caricli.render.pixels.sample_texture import sample_texture
from caricli.structures import Material, Mesh, Part, Pictures
from caricli.template.template import Template

WALL = (0.0, 0.2, 0.45, 0.7, 1.0)
"""Shares of the way from the edge down to a level foot."""

RINGS = ((0.03, 0.03), (0.1, 0.06), (0.22, 0.075), (0.42, 0.08), (0.7, 0.08))
"""How far from the foot's border to its middle, a share, and how far below it, shares of its mean radius: a rounded
rim."""

BELOW = 0.02
"""Of the head's height: how far below its lowest place, the edge or the chin, the foot begins."""

WIDTH, HEIGHT = 256, 32
"""Pixels of the picture: once around the neck, from the edge to the middle of the foot."""

DOWN = np.array([0.0, -1.0, 0.0])
"""On a head that stands upright."""

_SMOOTH = 0.05  # of the way around: the middle of the foot has no spots


@lru_cache(maxsize=4)
def neck_edge(template: Template) -> np.ndarray:
    """(L,) vertices around the open neck, from the middle of the nape in the order of the triangles beside it; none
    where there is no such edge. Of several within the neck the longest is meant."""
    neck = template.mask("neck")
    edges = [np.asarray(edge) for edge in igl.boundary_loop_all(np.asarray(template.faces, np.int64))]
    edge = max((edge for edge in edges if neck[edge].all()), key=len, default=np.zeros(0, np.int64))
    return np.roll(edge, -int(np.argmin(template.vertices[edge, 2]))) if len(edge) else edge


def close_neck(
    template: Template, vertices: np.ndarray, names: Sequence[str] = (), deltas: np.ndarray | None = None
) -> Part | None:
    """The rest of an open neck, down to a level foot that the head stands on.

    It begins at the edge itself, so there is no gap on any face, and moves with it.

    template: Template whose annotation names the neck. vertices: (V, 3) metres, the face. names, deltas: K expressions
    and (K, V, 3) metres, what they do to the face.
    Returns a Part, whose picture goes once around the neck and down to the middle of the foot; None for a head whose
    neck is closed or has no name.
    """
    edge = neck_edge(template)
    if not len(edge):
        return None
    vertices = np.asarray(vertices, float)
    rim = vertices[edge]
    radius = float(np.linalg.norm(rim - rim.mean(0), axis=1).mean())
    foot = rim.copy()
    foot[:, 1] = vertices[:, 1].min() - BELOW * np.ptp(vertices[:, 1])
    wall = _wall(rim, foot, _way_down(template, vertices))
    middle = foot.mean(0)
    inward, below = np.array(RINGS).T[:, :, None, None]
    places = np.concatenate([wall, foot + inward * (middle - foot) + below * radius * DOWN]).reshape(-1, 3)
    moves = np.zeros((0, *rim.shape)) if deltas is None else np.asarray(deltas, float)[:, edge]
    # The foot is as stiff as it is level.
    stiff = np.append(WALL, np.ones(len(RINGS)))[:, None, None]
    carried = moves.mean(1)[:, None]
    moved = (moves[:, None] * (1 - stiff) + carried[:, None] * stiff).reshape(len(moves), len(places), 3)
    mesh = _disc(np.vstack([places, middle + RINGS[-1][1] * radius * DOWN]), len(edge))
    materials = np.full(len(mesh.polygons), Material.BUST, np.int32)
    return Part("neck", mesh, materials, "neck", tuple(names), np.concatenate([moved, carried], axis=1))


def _way_down(template: Template, vertices: np.ndarray) -> np.ndarray:
    """(L, 3) directions in which the skin of a face (V, 3) ends at its edge."""
    ways = vertices[neck_edge(template)] - _above_edge(template) @ vertices
    lengths = np.maximum(np.linalg.norm(ways, axis=1), 1e-12)
    return np.asarray(ways / lengths[:, None])


@lru_cache(maxsize=4)
def _above_edge(template: Template) -> sp.csr_matrix:
    """(L, V) weights of the mean of those neighbours of each vertex of the edge that are not of it."""
    edge = neck_edge(template)
    inner = np.ones(len(template.vertices))
    inner[edge] = 0
    beside = igl.adjacency_matrix(np.asarray(template.faces, np.int64))[edge]
    return sp.diags(1 / np.maximum(beside @ inner, 1)) @ beside @ sp.diags(inner)


def _wall(rim: np.ndarray, foot: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """(W, L, 3) rings from an edge (L, 3) down to a foot (L, 3): Hermite's curves, which begin in the ways (L, 3) that
    the skin goes and end upright."""
    share = np.array(WALL)[:, None, None]
    length = np.linalg.norm(foot - rim, axis=1)[:, None]
    begin = (share**3 - 2 * share**2 + share) * length * ways
    end = (share**3 - share**2) * length * DOWN
    return rim + (3 * share**2 - 2 * share**3) * (foot - rim) + begin + end


def neck_picture(template: Template, texture: np.ndarray, skin: np.ndarray) -> np.ndarray | None:
    """The picture on what closes a neck: the colours at its edge, and soon those of the skin there, ever smoother.

    template: Template with UVs. texture: (S, S, 3) uint8, the skin's. skin: the same without the shade of hair, which
    ends at the edge. Returns (HEIGHT, WIDTH, 3) uint8, or None.
    """
    edge = neck_edge(template)
    if not len(edge) or template.uvs is None:
        return None
    row = _once_around(template, edge, texture)
    bare = _once_around(template, edge, skin)
    thrice = np.tile(bare, (3, 1))[None].astype(np.float32)
    smooth = cv2.GaussianBlur(thrice, (0, 0), sigmaX=_SMOOTH * WIDTH, sigmaY=1e-3)[0, WIDTH : 2 * WIDTH]
    share = np.linspace(0, 1, HEIGHT)[:, None, None]
    near = row + np.minimum(4 * share, 1) * (smooth - row)
    picture = near + np.maximum(share - 0.25, 0) / 0.75 * (bare.mean(0) - near)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def with_neck(pictures: Pictures, mesh: Mesh, template: Mesh) -> Pictures:
    """Pictures that a head wears, and one of what closes its neck, where that has none, in the colours of its skin.

    mesh: Mesh that they lie on. template: Template; of other meshes, and other UVs than its own, the neck is not known.
    """
    if pictures.skin is None or pictures.bust is not None or not isinstance(template, Template):
        return pictures
    if mesh.topology_id != template.topology_id or not mesh.same_layout(template):
        return pictures
    return replace(pictures, bust=neck_picture(template, pictures.skin, pictures.skin))


def _once_around(template: Template, edge: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """(WIDTH, 3) colours of a texture (S, S, 3) along an edge (L,)."""
    assert template.uvs is not None and template.uv_polygons is not None
    used = template.polygons >= 0
    place = np.zeros(len(template.vertices), np.int64)
    place[template.polygons[used]] = template.uv_polygons[used]
    colours = sample_texture(texture, template.uvs[place[np.append(edge, edge[0])]])
    across = (np.arange(WIDTH) + 0.5) / WIDTH * len(edge)
    return rows_at(across, np.arange(len(edge) + 1), colours)


def _disc(places: np.ndarray, around: int) -> Mesh:
    """Rings of so many vertices and their centre (W, 3) as quads and a fan; UVs go once around and down."""
    rings = len(places) // around
    number = np.arange(rings * around).reshape(rings, around)
    after = np.roll(number, -1, axis=1)
    corner = np.arange(rings * (around + 1)).reshape(rings, around + 1)
    left = corner[:, :-1]
    right = corner[:, 1:]
    last = np.full(around, rings * around)
    pad = np.full(around, -1)
    fan = np.stack([after[-1], number[-1], last, pad], -1)
    uv_fan = np.stack([right[-1], left[-1], corner.size + np.arange(around), pad], -1)
    quads = np.stack([after[:-1], number[:-1], number[1:], after[1:]], -1).reshape(-1, 4)
    uv_quads = np.stack([right[:-1], left[:-1], left[1:], right[1:]], -1).reshape(-1, 4)
    v, u = np.meshgrid(1 - np.arange(rings) / rings, np.arange(around + 1) / around, indexing="ij")
    tips = np.stack([(np.arange(around) + 0.5) / around, np.zeros(around)], -1)
    uvs = np.vstack([np.stack([u, v], -1).reshape(-1, 2), tips])
    return Mesh(places, np.vstack([quads, fan]), uvs, np.vstack([uv_quads, uv_fan]))
