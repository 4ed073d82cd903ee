"""What closes the open neck of a head."""

from collections.abc import Sequence
from functools import lru_cache

import cv2
import igl
import numpy as np

from caricli.render.sample_texture import sample_texture
from caricli.structures import Material, Mesh, Part
from caricli.template.template import Template

RINGS = ((0.0, 0.0), (0.03, 0.03), (0.1, 0.06), (0.22, 0.075), (0.42, 0.08), (0.7, 0.08))
"""How far from the edge to its middle, a share, and how far below it, shares of its mean radius: a rounded rim."""

WIDTH, HEIGHT = 256, 32
"""Pixels of the picture: once around the neck, from the edge to the middle."""

_SMOOTH = 0.05  # of the way around: the middle of the cap has no spots


@lru_cache(maxsize=4)
def neck_edge(template: Template) -> np.ndarray:
    """(L,) vertices around the open neck, from the middle of the nape in the order of the triangles beside it; none
    where there is no such edge."""
    edge = np.asarray(igl.boundary_loop(np.asarray(template.faces, np.int64)), np.int64).ravel()
    if len(edge) < 3 or not template.mask("neck")[edge].all():
        return edge[:0]
    return np.roll(edge, -int(np.argmin(template.vertices[edge, 2])))


def close_neck(
    template: Template, vertices: np.ndarray, names: Sequence[str] = (), deltas: np.ndarray | None = None
) -> Part | None:
    """A cap on the open neck: it begins at the edge itself, so there is no gap on any face, and moves with it.

    template: Template whose annotation names the neck. vertices: (V, 3) metres, the face. names, deltas: K expressions
    and (K, V, 3) metres, what they do to the face.
    Returns a Part, whose picture goes once around the neck and down to the middle of the cap; None for a head whose
    neck is closed or has no name.
    """
    edge = neck_edge(template)
    if not len(edge):
        return None
    rim = np.asarray(vertices, float)[edge]
    middle = rim.mean(0)
    # As seen from outside the edge goes round the other way than the cap.
    area = np.cross(rim - middle, np.roll(rim, -1, axis=0) - middle).sum(0)
    down = -area / max(float(np.linalg.norm(area)), 1e-12)
    radius = float(np.linalg.norm(rim - middle, axis=1).mean())
    moves = np.zeros((0, *rim.shape)) if deltas is None else np.asarray(deltas, float)[:, edge]
    inward = np.array([share for share, _ in RINGS])[:, None, None]
    sink = np.array([depth for _, depth in RINGS])[:, None, None] * radius * down
    # What is uneven at the edge is soon flat.
    uneven = ((rim - middle) @ down)[:, None] * down * ((1 - inward) ** 3 - (1 - inward))
    places = (rim + inward * (middle - rim) + sink + uneven).reshape(-1, 3)
    centre = middle + RINGS[-1][1] * radius * down
    carried = moves.mean(1)[:, None]
    moved = (moves[:, None] * (1 - inward) + carried[:, None] * inward).reshape(len(moves), len(RINGS) * len(edge), 3)
    mesh = _disc(np.vstack([places, centre]), len(edge))
    materials = np.full(len(mesh.polygons), Material.BUST, np.int32)
    return Part("neck", mesh, materials, "neck", tuple(names), np.concatenate([moved, carried], axis=1))


def neck_picture(template: Template, texture: np.ndarray) -> np.ndarray | None:
    """The picture on the cap of a neck: the colours of the skin at its edge, towards the middle ever smoother.

    template: Template with UVs. texture: (S, S, 3) uint8, the skin's. Returns (HEIGHT, WIDTH, 3) uint8, or None.
    """
    edge = neck_edge(template)
    if not len(edge) or template.uvs is None:
        return None
    assert template.uv_polygons is not None
    used = template.polygons >= 0
    place = np.zeros(len(template.vertices), np.int64)
    place[template.polygons[used]] = template.uv_polygons[used]
    colours = sample_texture(texture, template.uvs[place[np.append(edge, edge[0])]])
    across = (np.arange(WIDTH) + 0.5) / WIDTH * len(edge)
    row = np.stack([np.interp(across, np.arange(len(edge) + 1), channel) for channel in colours.T], 1)
    size = _SMOOTH * WIDTH
    thrice = np.tile(row, (3, 1))[None].astype(np.float32)
    smooth = cv2.GaussianBlur(thrice, (0, 0), sigmaX=size, sigmaY=1e-3)[0, WIDTH : 2 * WIDTH]
    share = np.linspace(0, 1, HEIGHT)[:, None, None]
    near = row + np.minimum(4 * share, 1) * (smooth - row)
    picture = near + np.maximum(share - 0.25, 0) / 0.75 * (row.mean(0) - near)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


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
