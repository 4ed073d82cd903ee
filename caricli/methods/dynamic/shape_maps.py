"""What the shapes of a person say of the paint: maps in the chart of the face, of one expression and of another."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Self

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.alignment.weighted_similarities import weighted_similarities
from caricli.geometry.lines.rows_at import rows_at
from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.mouth_parts import MouthParts, look_inside
from caricli.render.sky import DIRECTIONS, sky_visibility

CHANNELS = (
    *("displacement_x", "displacement_y", "displacement_z"),
    *("source_normal_x", "source_normal_y", "source_normal_z", "source_curvature", "source_area"),
    *("source_openness", "source_gap", "target_normal_x", "target_normal_y", "target_normal_z"),
    *("target_curvature", "target_area", "target_openness", "target_gap"),
    *("source_teeth", "source_flesh", "source_depth", "target_teeth", "target_flesh", "target_depth"),
)
"""Of `pair_maps`, in their order."""

PART = 0.25
"""Of the neutral face's width: the displacement and the gap between lips that are 1."""

BENT = 10.0
"""Change of mean normal curvature, for one over the neutral face's width, whose map is tanh 1."""

REACH = 0.03
"""Of the neutral face's width: the displacement whose attention is 0.63."""

_WAYS = DIRECTIONS[::3]
_OWN = 7  # channels of one shape
GAP = 6  # which of them is the gap
_ABOVE = 0.5  # of the chart's height
_ROUNDS = 4  # of fits that count less what moves
_STILL = 0.001  # of the face's width: what moves less counts alike
_FINER = 4  # points for each along a lip
_SMALL = 1e-12


@dataclass(frozen=True, eq=False)
class ShapeFields:
    """What one shape says at the vertices of the chart.

    places: (..., N, 3) in the frame of the person's neutral face, for its width. values: (..., N, 7) normal, change
    of curvature, change of area, openness and gap between the lips, each from -1 to 1. inside: (..., M, 3) at the M
    texels between the lips, from 0 to 1, how much of what is seen behind them is teeth, and gums or tongue, and how far
    behind it is.
    """

    places: np.ndarray
    values: np.ndarray
    inside: np.ndarray

    @classmethod
    def stacked(cls, shapes: "Sequence[ShapeFields]") -> Self:
        """Of several shapes, those of each along a new first axis."""
        return cls(*(np.stack([getattr(shape, field.name) for shape in shapes]) for field in fields(cls)))

    def __getitem__(self, rows: Any) -> Self:
        """Of some of the shapes that are stacked, as of arrays."""
        return type(self)(self.places[rows], self.values[rows], self.inside[rows])


class PersonShapes:
    """A person's neutral face, against which the person's other shapes are seen.

    The frame is that in which the neutral face lies as its chart does: turning and moving what is given changes
    nothing. A shape is first laid on the neutral face by a rigid fit that counts most where it is as that one.
    """

    def __init__(self, grid: ChartGrid, neutral: np.ndarray, mouth: MouthParts | None = None) -> None:
        """grid: ChartGrid. neutral: (V, 3) metres. mouth: what is inside it, or None where that is not told.

        Raises InputError where the face is not of the chart's mesh.
        """
        self.grid = grid
        self.mouth = mouth
        chart = grid.chart
        self.skin = chart.faces[~chart.membrane]
        count = len(chart.vertices)
        entries = (self.skin.ravel(), np.repeat(np.arange(len(self.skin)), 3))
        self.around = sp.csr_matrix((np.ones(self.skin.size), entries), (count, len(self.skin)))
        edges = np.concatenate([self.skin[:, [0, 1]], self.skin[:, [1, 2]], self.skin[:, [2, 0]]])
        self.edges = np.unique(np.sort(edges, axis=1), axis=0)
        own = self._own(neutral)
        flat = np.column_stack([chart.uvs, np.zeros(count)])
        _, turn, _ = similarity(own, flat)
        turned = (own - own.mean(0)) @ turn.T
        self.width = float(np.ptp(turned[:, 0]))
        self.neutral = turned / self.width
        self.calm = self._raw(self.neutral)

    def fields(self, vertices: np.ndarray, weights: np.ndarray | None = None) -> ShapeFields:
        """What a shape (V, 3), metres, of the same person says.

        weights: (K,) of the mouth's expressions that move what is in it, None for none of them.
        """
        own = self._own(vertices) / self.width
        turn, shift = self._way(own)
        places = own @ turn.T + shift
        normals, curvature, areas = self._raw(places)
        _, calm_curvature, calm_areas = self.calm
        bent = np.tanh((curvature - calm_curvature) / BENT)
        grown = np.tanh(np.log(np.maximum(areas, _SMALL) / np.maximum(calm_areas, _SMALL)))
        columns = [normals, bent, grown, 2 * self._openness(places, normals) - 1, self._gap(places) / PART]
        inside = np.zeros((int(self.grid.mouth.sum()), 3), np.float32)
        if self.mouth is not None:
            moved = self.mouth.vertices if weights is None else self.mouth.moved(weights)
            between = self.grid.bake_own(places)[self.grid.mouth]
            inside = look_inside(self.mouth, moved / self.width @ turn.T + shift, between)
            inside[:, 2] = np.tanh(inside[:, 2] / PART)
        return ShapeFields(places, np.column_stack(columns).astype(np.float32), inside)

    def _own(self, vertices: np.ndarray) -> np.ndarray:
        """(N, 3) those of the chart."""
        if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) <= self.grid.chart.vertices.max():
            raise InputError(f"expected vertices of the mesh that the chart was made of, found {vertices.shape}")
        return np.asarray(vertices, float)[self.grid.chart.vertices]

    def _way(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How places (N, 3) come to lie on the neutral face: a rotation (3, 3) and a shift (3,)."""
        # The jaw moves most; what is above it is where the fit starts.
        weights = (self.grid.chart.uvs[:, 1] > _ABOVE) + _SMALL
        for _ in range(_ROUNDS):
            _, turn, shift = weighted_similarities(places, self.neutral, weights, scaling=False)
            away = np.linalg.norm(places @ turn.T + shift - self.neutral, axis=1)
            weights = 1 / (away + _STILL) ** 2
        return turn, shift

    def _raw(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normals (N, 3), curvatures (N,), convex ones above 0, and areas (N,) of the surface around the vertices."""
        crosses = triangle_normals(places, self.skin)
        sums = self.around @ crosses
        normals = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), _SMALL)
        first, second = self.edges.T
        along = places[first] - places[second]
        turned = ((normals[first] - normals[second]) * along).sum(1)
        lengths = (along**2).sum(1)
        ends = self.edges.T.ravel()
        bent, spread = (np.bincount(ends, np.tile(each, 2), len(places)) for each in (turned, lengths))
        return normals, bent / np.maximum(spread, _SMALL), self.around @ np.linalg.norm(crosses, axis=1)

    def _openness(self, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """(N,) from 0 to 1, how much of the light from all sides reaches the vertices."""
        facing = np.maximum(normals @ _WAYS.T, 0)
        seen = sky_visibility(places, self.skin, normals, directions=_WAYS)
        return (facing * seen).sum(1) / np.maximum(facing.sum(1), _SMALL)

    @cached_property
    def _lips(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the chart along the two lips, from corner to corner; none where there is no membrane."""
        chart = self.grid.chart
        if not chart.membrane.any():
            return np.zeros(0, int), np.zeros(0, int)
        loop = np.asarray(igl.boundary_loop_all(np.asarray(chart.faces[chart.membrane], np.int64))[0])
        loop = np.roll(loop, -int(chart.uvs[loop, 0].argmin()))
        turn = int(chart.uvs[loop, 0].argmax())
        return loop[: turn + 1], np.append(loop[turn:], loop[0])

    def _gap(self, places: np.ndarray) -> np.ndarray:
        """(N,) how far vertices of one lip are from the other, for the face's width; zero elsewhere."""
        gaps = np.zeros(len(places))
        for line, other in (self._lips, self._lips[::-1]):
            steps = np.arange(_FINER * len(other)) / _FINER
            finer = rows_at(steps, np.arange(len(other)), places[other])
            gaps[line] = np.linalg.norm(places[line, None] - finer[None], axis=2).min(1, initial=np.inf)
        return gaps


def pair_maps(grid: ChartGrid, source: ShapeFields, target: ShapeFields) -> np.ndarray:
    """Maps of two shapes of a person in the chart: what a network sees in the place of codes of expressions.

    Returns (..., S, S, 23) float32, the CHANNELS: displacement from source to target, and of both their normals, how
    curvature and (as logarithm) area differ from the neutral face's, openness to light from all sides, and on the
    membrane the gap between the lips and what lies behind it, which `PersonShapes` is told. Lengths are in quarters of
    the neutral face's width; all is about -1 to 1, zero where nothing is covered.
    """
    displacement = (target.places - source.places) / PART
    skin = _baked(grid, np.concatenate([displacement, source.values, target.values], axis=-1))
    skin[..., ~grid.mouth, 3 + GAP :: _OWN] = 0
    mouth = np.zeros((*skin.shape[:-1], 2 * source.inside.shape[-1]), np.float32)
    mouth[..., grid.mouth, :] = np.concatenate([source.inside, target.inside], axis=-1)
    return np.concatenate([skin, mouth], axis=-1)


def pair_attention(grid: ChartGrid, source: ShapeFields, target: ShapeFields) -> np.ndarray:
    """Where the paint changes, told from where the surface moves (expressions paper, section 3.3.2).

    ``1 - exp(-moved / REACH)``; between the lips what their gap changes counts as moved, too.

    Returns (..., S, S) float32 from 0 to 1.
    """
    moved = np.linalg.norm(target.places - source.places, axis=-1)
    parted = PART * (target.values[..., GAP] - source.values[..., GAP])
    baked = _baked(grid, np.stack([moved, parted], axis=-1))
    change = np.where(grid.mouth, np.maximum(baked[..., 0], np.abs(baked[..., 1])), baked[..., 0])
    return 1 - np.exp(-change / np.float32(REACH))


def _baked(grid: ChartGrid, values: np.ndarray) -> np.ndarray:
    """Values (..., N, C) of the chart's vertices at the texels, (..., S, S, C) float32."""
    columns = values.reshape(-1, *values.shape[-2:]).transpose(1, 0, 2)
    baked = grid.bake_own(columns.reshape(len(columns), -1))
    texels = baked.reshape(grid.size, grid.size, -1, values.shape[-1]).transpose(2, 0, 1, 3)
    return texels.reshape(*values.shape[:-2], grid.size, grid.size, values.shape[-1])
