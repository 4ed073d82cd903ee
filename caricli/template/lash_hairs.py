"""Single lashes along the strips that the base mesh has in their place."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.flattening.quad_grid import quad_grid
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.repair.components import component_labels
from caricli.structures import Mesh

SIDES = 3
"""Of a lash, which is a thin pyramid with a bend."""


@dataclass(frozen=True)
class LashStyle:
    """What lashes look like.

    spacing: metres between roots along the lid. thickness: metres at the root. fan: how far the outermost lashes lean
    away from the middle of the lid, of the lid's length. shortest: length of the shortest lash, of the strip's width.
    clump: how far the tips of neighbours come together, of their spacing. rows: where a lash has a ring of vertices or
    its tip, from where the strip is in the lid (0) to its free edge (1). lower, fine: length and thickness of lashes
    that hang down, of those that stand up.
    """

    spacing: float = 0.0011
    thickness: float = 0.00045
    fan: float = 0.05
    shortest: float = 0.72
    clump: float = 0.8
    rows: tuple[float, ...] = (0.22, 0.45, 0.72, 1.0)
    lower: float = 0.5
    fine: float = 0.6


@dataclass(frozen=True, eq=False)
class LashHairs:
    """Lashes of W vertices on strips of B vertices.

    mesh: Mesh of them. weights: (W, B) sparse, what part each vertex takes in the moves of the strips.
    """

    mesh: Mesh
    weights: sp.csr_matrix


def lash_hairs(strips: Mesh) -> LashHairs:
    """Lashes along strips.

    strips: Mesh of grids of quads, each with one long side behind the edge of a lid, at lower z, and one that is free.
    """
    style = LashStyle()
    labels = component_labels(strips.faces, len(strips.vertices))
    rings = np.repeat(np.arange(len(style.rows)), [SIDES] * (len(style.rows) - 1) + [1])
    weights, offsets = [], []
    count = 0
    for label in np.unique(labels):
        own = strips.polygons[labels[strips.polygons[:, 0]] == label]
        grid = quad_grid(own)
        rooted = grid if strips.vertices[grid[0], 2].mean() < strips.vertices[grid[-1], 2].mean() else grid[::-1]
        along, lean, reach = _spread(strips.vertices[rooted], style)
        hanging = strips.vertices[rooted[-1], 1].mean() < strips.vertices[rooted[0], 1].mean()
        rows = np.array(style.rows)
        across = reach[:, None] * (rows[0] + (style.lower if hanging else 1.0) * (rows - rows[0]))
        thickness = (style.fine if hanging else 1.0) * style.thickness
        lines = _on_grid(
            rooted, (along[:, None] + lean[:, None] * across).ravel(), across.ravel(), len(strips.vertices)
        )
        first = len(style.rows) * np.arange(len(along))
        weights.append(lines[(first[:, None] + rings).ravel()])
        offsets.append(_rings((lines @ strips.vertices).reshape(*across.shape, 3), thickness))
        count += len(along)
    moved = sp.vstack(weights).tocsr()
    polygons, uvs = _hair(len(style.rows), count)
    return LashHairs(Mesh(moved @ strips.vertices + np.concatenate(offsets), polygons, uvs, polygons), moved)


def _spread(strip: np.ndarray, style: LashStyle) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where lashes (N,) of a strip (R, C, 3) stand along it, how far they lean by their tips, and their lengths."""
    lengths = arc_lengths(strip[-1])
    count = max(int(lengths[-1] / style.spacing), 2)
    columns = np.arange(len(lengths)) / (len(lengths) - 1)
    along = np.interp((np.arange(count) + 0.5) / count * lengths[-1], lengths, columns)
    pairs = np.where(np.arange(count) % 2, -0.5, 0.5) * style.clump / count
    lean = 2 * style.fan * (along - 0.5) + pairs
    # The golden section spreads lengths evenly without a pattern that the eye would see.
    reach = style.shortest + (1 - style.shortest) * ((np.arange(count) * 0.6180339887) % 1.0)
    return along, lean, reach


def _on_grid(grid: np.ndarray, along: np.ndarray, across: np.ndarray, count: int) -> sp.csr_matrix:
    """(N, count) sparse bilinear weights of points on a grid (R, C) of ids; along, across: (N,), from 0 to 1."""
    rows, columns = grid.shape
    points = np.arange(len(along))
    row = np.clip(across, 0, 1) * (rows - 1)
    column = np.clip(along, 0, 1) * (columns - 1)
    r = np.minimum(row.astype(int), rows - 2)
    c = np.minimum(column.astype(int), columns - 2)
    parts = [
        (grid[r + i, c + j], np.abs(1 - i - (row - r)) * np.abs(1 - j - (column - c))) for i in (0, 1) for j in (0, 1)
    ]
    ids, values = (np.concatenate(x) for x in zip(*parts, strict=True))
    return sp.csr_matrix((values, (np.tile(points, 4), ids)), shape=(len(points), count))


def _rings(centres: np.ndarray, thickness: float) -> np.ndarray:
    """(N (SIDES (R - 1) + 1), 3) offsets of the corners around lines (N, R, 3) that thin to their tips, the last."""
    along = np.gradient(centres, axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    first = np.cross(along, [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(along, first)
    turns = 2 * np.pi * np.arange(SIDES) / SIDES
    count, rows, _ = centres.shape
    thin = thickness / 2 * (1 - np.arange(rows - 1) / (rows - 1)) ** 0.7
    ring = first[:, :-1, None] * np.cos(turns)[:, None] + second[:, :-1, None] * np.sin(turns)[:, None]
    return np.concatenate([(thin[:, None, None] * ring).reshape(count, -1, 3), np.zeros((count, 1, 3))], 1).reshape(
        -1, 3
    )


def _hair(rows: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Polygons and UVs of so many lashes with so many rows; all lie in one place of the picture."""
    size = SIDES * (rows - 1) + 1
    rings = np.arange(size - 1).reshape(rows - 1, SIDES)
    after = np.roll(rings, -1, axis=1)
    sides = np.stack([rings[:-1], after[:-1], after[1:], rings[1:]], -1).reshape(-1, 4)
    tip = np.stack([rings[-1], after[-1], np.full(SIDES, size - 1), np.full(SIDES, -1)], -1)
    one = np.concatenate([sides, tip])
    polygons = np.concatenate([np.where(one >= 0, one + k * size, -1) for k in range(count)])
    u, v = np.meshgrid(np.linspace(0.1, 0.7, SIDES), np.linspace(0.1, 0.7, rows - 1))
    uvs = np.concatenate([np.stack([u, v], -1).reshape(-1, 2), [[0.4, 0.9]]])
    return polygons.astype(np.int32), np.tile(uvs, (count, 1))
