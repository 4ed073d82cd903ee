"""Where a function on a mesh is zero."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class MeshLine:
    """A line across the triangles of a mesh.

    ends: (N, 2) vertex ids, the edge that each point lies on. share: (N,) of the second end; a point is
    ``(1 - share) * vertices[ends[:, 0]] + share * vertices[ends[:, 1]]``. A closed line ends where it begins.
    """

    ends: np.ndarray
    share: np.ndarray

    def of(self, values: np.ndarray) -> np.ndarray:
        """What is known at vertices (V, ...) at its points (N, ...)."""
        share = self.share.reshape(-1, *([1] * (values.ndim - 1)))
        return (1 - share) * values[self.ends[:, 0]] + share * values[self.ends[:, 1]]

    def part(self, start: int, end: int) -> "MeshLine":
        """Its points from start to before end."""
        return MeshLine(self.ends[start:end], self.share[start:end])


def zero_lines(values: np.ndarray, faces: np.ndarray) -> list[MeshLine]:
    """The zeros of a function that is linear in every triangle, as lines from triangle to triangle.

    values: (V,); an exact zero counts as positive. faces: (F, 3).
    Returns MeshLines of at least two points, in an order that depends on the mesh alone.
    """
    above = values >= 0
    crossed = above[faces]
    crossed = faces[crossed.any(1) & ~crossed.all(1)]
    if not len(crossed):
        return []
    # In such a triangle one corner is alone on its side; the line runs over the two edges that meet there.
    sides = above[crossed]
    alone = np.argmax(sides == (sides.sum(1, keepdims=True) == 1), axis=1)
    rows = np.arange(len(crossed))
    tips = crossed[rows, alone]
    pairs = [np.stack([tips, crossed[rows, (alone + k) % 3]], axis=1) for k in (1, 2)]
    edges, numbers = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0, return_inverse=True)
    numbers = numbers.reshape(2, -1)
    low = values[edges[:, 0]]
    share = low / (low - values[edges[:, 1]])
    return [MeshLine(edges[chain], share[chain]) for chain in _chains(numbers, len(edges))]


def _chains(links: np.ndarray, count: int) -> list[np.ndarray]:
    """Lines of nodes. links: (2, L) pairs of nodes, of which each has two at most, on a mesh that is a surface."""
    next_to: list[list[int]] = [[] for _ in range(count)]
    for a, b in zip(*links.tolist(), strict=True):
        next_to[a].append(b)
        next_to[b].append(a)
    seen = [False] * count
    chains = []
    # First the lines that have an end, then the rings.
    for start in [*(k for k in range(count) if len(next_to[k]) == 1), *range(count)]:
        if seen[start]:
            continue
        chain = [start]
        seen[start] = True
        while True:
            further = [node for node in next_to[chain[-1]] if not seen[node]]
            if not further:
                break
            seen[further[0]] = True
            chain.append(further[0])
        if len(chain) > 2 and len(next_to[start]) > 1 and start in next_to[chain[-1]]:
            chain.append(start)
        if len(chain) > 1:
            chains.append(np.array(chain))
    return chains
