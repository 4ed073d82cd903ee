"""A row of teeth in its gums, modelled on the band that the base mesh has in their place."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.flattening.quad_grid import quad_grid
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.cubic_spline import CubicSpline
from caricli.structures import Material, Mesh

COLUMNS = (-1.0, -0.72, 0.0, 0.72, 1.0)
"""Across a crown, of half its width; at both ends its front and its back meet."""

SCALLOPS = 4
"""Columns of gum for every tooth."""

FRONT_ROWS = (
    (-0.3, 0.1),
    (0.3, -0.02),
    (0.75, 0.03),
    (0.95, 0.08),
    (1.0, 0.16),
    (0.92, 0.24),
    (0.45, 0.6),
    (-0.3, 0.9),
)
"""Of a tooth that cuts, from the front over its edge to the back: height from the gum line (0) to the edge (1), depth
from the outer face of the band (0) to the inner one (1)."""

BACK_ROWS = ((-0.3, 0.08), (0.3, -0.02), (0.8, 0.08), (1.0, 0.26), (0.84, 0.5), (0.98, 0.74), (0.4, 1.0), (-0.3, 0.92))
"""Of a tooth that grinds: two rims and the groove between them."""

GUM_ROWS = ((-0.62, 0.02), (-0.3, -0.03), (0.0, -0.04), (0.0, 0.16), (0.0, 0.84), (0.0, 1.03), (-0.6, 1.06))
"""Of the gums, likewise; in the rows of height 0 gums rise between teeth."""


@dataclass(frozen=True)
class ArchStyle:
    """What teeth look like.

    upper, lower: widths of the teeth of one side from the middle, in any unit: they share the length of the band.
    cutting: how many of them cut, the others grind.
    edges: heights of the cutting teeth's edges, in the band's.
    corner: how far the corners of an edge are rounded off, of the height.
    point: how far the last of the cutting teeth is pointed, of the height.
    square: exponent of the crown's outline from above; 2 is an ellipse.
    waist: width of a crown at the gums, of its width.
    papilla: how far gums rise between teeth, of the height.
    """

    upper: tuple[float, ...]
    lower: tuple[float, ...]
    cutting: int
    edges: tuple[float, ...]
    corner: float
    point: float
    square: float
    waist: float
    papilla: float


STYLES = {
    "natural": ArchStyle(
        upper=(8.5, 6.6, 7.6, 7.0, 6.8, 10.2, 9.6),  # mm, means of adults (Wheeler's Dental Anatomy, tables)
        lower=(5.3, 5.7, 6.8, 7.0, 7.1, 11.2, 10.7),
        cutting=3,
        edges=(1.0, 0.94, 1.02),
        corner=0.1,
        point=0.12,
        square=2.6,
        waist=0.84,
        papilla=0.3,
    ),
    "cartoon": ArchStyle(
        upper=(12.0, 10.0, 10.0, 12.0, 14.0),
        lower=(10.0, 10.0, 10.0, 12.0, 14.0),
        cutting=3,
        edges=(1.0, 0.98, 0.97),
        corner=0.16,
        point=0.0,
        square=2.2,
        waist=0.95,
        papilla=0.12,
    ),
}
"""By name."""


def dental_arch(band: Mesh, upper: bool, style: ArchStyle) -> tuple[Mesh, np.ndarray]:
    """Teeth and gums along a band.

    band: Mesh of one grid of quads of four rows: the far end of the gums, the gum line, the edge of the teeth, and
    where gums end inside; from one last tooth to the other. upper: whose widths are taken. style: ArchStyle.
    Returns a Mesh of quads with UVs, the crowns in its lower half and the gums in its upper one, and the Material of
    every polygon.
    """
    shape = _Band(band)
    half = np.array(style.upper if upper else style.lower)
    widths = np.concatenate([half[::-1], half]) / (2 * half.sum())
    ends = np.concatenate([[0.0], np.cumsum(widths)])
    order = [*range(len(half) - 1, -1, -1), *range(len(half))]
    crowns = [_crown(shape, ends[k : k + 2], order[k], style) for k in range(len(order))]
    gums = _gums(shape, ends, style)
    grids = [*crowns, gums]
    boxes = [(ends[k], 0.0, widths[k], 0.5) for k in range(len(crowns))] + [(0.0, 0.5, 1.0, 0.5)]
    mesh = _joined(grids, boxes)
    quads = [(g.shape[0] - 1) * (g.shape[1] - 1) for g in grids]
    kinds = [Material.TEETH] * len(crowns) + [Material.GUMS]
    return mesh, np.repeat(np.array(kinds, np.int32), quads)


class _Band:
    """A band as a function of where along it, how high and how deep."""

    def __init__(self, band: Mesh) -> None:
        rows = np.asarray(band.vertices, float)[quad_grid(band.polygons)]
        along = arc_lengths(rows[1])
        self.rows = CubicSpline(along / along[-1], np.moveaxis(rows, 1, 0))

    def points(self, along: np.ndarray, height: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(..., 3) points; along: from 0 to 1; height and depth as in ``FRONT_ROWS``; of shapes that go together."""
        far, line, edge, inner = np.moveaxis(self.rows(np.clip(along, 0, 1)), -2, 0)
        up = np.where(height[..., None] > 0, edge - line, line - far)
        return line + height[..., None] * up + depth[..., None] * (inner - line)


def _crown(band: _Band, ends: np.ndarray, number: int, style: ArchStyle) -> np.ndarray:
    """(R, C, 3) sheet of a crown from its front to its back. number: from the middle, 0 is the first."""
    cuts = number < style.cutting
    height, depth = np.array(FRONT_ROWS if cuts else BACK_ROWS).T[:, :, None]
    across = np.array(COLUMNS)[None]
    top = style.edges[number] if cuts else 1.0
    pointed = style.point if number == style.cutting - 1 else 0.0
    reach = top - style.corner * across**4 - pointed * np.abs(across)
    above = np.clip(height, 0, 1)
    heights = np.where(height > 0, height * reach, height)
    waist = style.waist + (1 - style.waist) * np.sin(0.5 * np.pi * np.clip(above / 0.8, 0, 1))
    round_ = (1 - np.abs(across) ** style.square) ** (1 / style.square)
    middle = 0.5 + (depth[len(depth) // 2] - 0.5) * above
    depths = middle + (depth - middle) * round_
    along = ends.mean() + across * np.ptp(ends) / 2 * waist
    return band.points(along, heights, depths)


def _gums(band: _Band, ends: np.ndarray, style: ArchStyle) -> np.ndarray:
    """(R, C, 3) sheet of the gums from outside to inside."""
    share = np.arange(SCALLOPS) / SCALLOPS
    along = np.concatenate([(ends[:-1, None] + np.diff(ends)[:, None] * share).ravel(), ends[-1:]])
    between = np.concatenate([np.tile(np.cos(np.pi * share) ** 4, len(ends) - 1), [1.0]])
    height, depth = np.array(GUM_ROWS).T[:, :, None]
    return band.points(along, np.where(height == 0, style.papilla * between, height), depth)


def _joined(grids: list[np.ndarray], boxes: list[tuple[float, float, float, float]]) -> Mesh:
    """A Mesh of sheets (R, C, 3), each in its box (left, bottom, width, height) of the picture."""
    vertices, uvs, polygons = [], [], []
    count = 0
    for grid, (left, bottom, width, height) in zip(grids, boxes, strict=True):
        rows, columns = grid.shape[:2]
        ids = count + np.arange(rows * columns).reshape(rows, columns)
        quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1)
        v, u = np.meshgrid(np.linspace(0.02, 0.98, rows), np.linspace(0.02, 0.98, columns), indexing="ij")
        vertices.append(grid.reshape(-1, 3))
        uvs.append(np.stack([left + width * u, bottom + height * v], -1).reshape(-1, 2))
        polygons.append(quads.reshape(-1, 4))
        count += rows * columns
    quads = np.concatenate(polygons).astype(np.int32)
    return Mesh(np.concatenate(vertices), quads, np.concatenate(uvs), quads)
