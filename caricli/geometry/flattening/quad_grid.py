"""Rows and columns of a rectangular patch of quads."""

import numpy as np

from caricli.errors import InputError


def quad_grid(polygons: np.ndarray) -> np.ndarray:
    """Vertex ids of a patch of quads that is a grid without holes, as rows and columns.

    polygons: (P, 4) quads, all turned the same way.
    Returns (R, C) ids, R <= C, P = (R - 1)(C - 1); the first row starts at the corner of the lowest id, or ends there
    where a shorter side comes after it, and rows and columns turn as the quads do. Raises InputError for a patch that
    is no such grid.
    """
    quads = np.asarray(polygons)
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], -1).reshape(-1, 2)
    inner = {(b, a) for a, b in edges.tolist()}
    after = {a: b for a, b in edges.tolist() if (a, b) not in inner}
    ids, counts = np.unique(quads, return_counts=True)
    corners = ids[counts == 1]
    if len(corners) != 4:
        raise InputError(f"expected a grid of quads with 4 corners, found {len(corners)}")
    loop = [int(corners[0])]
    while len(loop) <= len(after) and after.get(loop[-1]) not in (None, loop[0]):
        loop.append(after[loop[-1]])
    turns = np.flatnonzero(np.isin(loop, corners))
    columns = int(turns[1]) + 1 if len(turns) == 4 else 0
    rows = int(turns[2] - turns[1]) + 1 if len(turns) == 4 else 0
    if len(loop) != len(after) or (rows - 1) * (columns - 1) != len(quads):
        raise InputError("expected a grid of quads, found another patch")
    grid = np.empty((rows, columns), np.int64)
    grid[0] = loop[:columns]
    grid[:, 0] = [loop[0], *loop[:-rows:-1]]
    last = {frozenset(np.delete(quad, k).tolist()): int(quad[k]) for quad in quads for k in range(4)}
    for row in range(rows - 1):
        for column in range(columns - 1):
            corner = frozenset(map(int, (grid[row, column], grid[row, column + 1], grid[row + 1, column])))
            grid[row + 1, column + 1] = last.get(corner, -1)
    if not np.array_equal(np.sort(grid.ravel()), ids):
        raise InputError("expected a grid of quads, found another patch")
    return grid if rows <= columns else grid.T[:, ::-1]
