"""Random colours of a head, without light: skin, lips, brows, lashes, stubble, freckles, hair."""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree
from skimage.measure import points_in_poly

from caricli.data.appearance import Appearance, random_appearance
from caricli.geometry.smooth_step import smooth_step
from caricli.geometry.triangle_normals import triangle_normals
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.render.pixels.levels import to_bytes
from caricli.render.pixels.paint import mix
from caricli.render.pixels.srgb import to_srgb
from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    COUNT,
    LOWER_LID,
    LOWER_LIP,
    LOWER_LIP_INSIDE,
    MOUTH,
    POINT_NAMES,
    UPPER_LID,
    UPPER_LIP,
    UPPER_LIP_INSIDE,
)
from caricli.template.annotation import EARS
from caricli.template.template import Template

ALBEDOS = 600
"""Random albedos that a morphable model's colours are learnt from."""

PALE = np.array([0.95, 0.76, 0.62])
"""Linear light of skin without pigment, and"""
MELANIN = np.array([2.1, 2.9, 3.8])
BLOOD = np.array([0.12, 0.85, 0.72])
"""what each unit of melanin and of blood absorbs of it."""

CAVITY = np.array([0.16, 0.025, 0.03])
"""Linear colour of the inside of the mouth."""

NEAR_MOUTH = 0.6
"""Distance from the mouth, in widths of the face, within which it is known how far the lips are."""

SATURATION = 1.2
"""Of a cartoon's colours."""

_BROWS = (tuple(BROW_LEFT), tuple(reversed(BROW_RIGHT)))
"""From the nose outwards."""

_CHEEKS = ((41, 41, 48, 2), (46, 46, 54, 14))
"""Points whose mean is a cheek: twice below the eye, corner of the mouth, side of the face."""

_EYE_CORNERS = (POINT_NAMES["eye_outer_right"], POINT_NAMES["eye_outer_left"])
_BELOW_EYES = (40, 41, 46, 47)
_BRIDGE_AND_TIP = (28, POINT_NAMES["nose_tip"])
_JAW = slice(2, 15)
"""Of iBUG's points, without the ends beside the ears."""


class AlbedoPainter:
    """Places on a head with all that painting must know of them, so that many albedos share it.

    Colours are functions of the place on the surface alone, so that they agree across the seams of the UVs. Lengths are
    in widths of the face between the outer corners of the eyes.
    """

    def __init__(self, template: Template, weights: sp.csr_matrix, grain: float) -> None:
        """weights: sparse (P, V), the places. grain: metres between neighbouring places."""
        vertices = template.vertices
        marks = vertices[template.annotation.landmarks[:COUNT]]
        middle = marks[list(_EYE_CORNERS)].mean(0)
        unit = np.linalg.norm(marks[_EYE_CORNERS[1]] - marks[_EYE_CORNERS[0]])
        self.template = template
        self.weights = weights
        self.surface = (vertices - middle) / unit
        self.marks = (marks - middle) / unit
        self.grain = grain / float(unit)
        self.places = weights @ self.surface
        self._find_regions()
        self._find_curves()
        self._find_lips()

    def _find_regions(self) -> None:
        """How far every place belongs to a region, from 0 to 1."""
        self.scalp = self._mask("scalp", rounds=6)
        self.cavities = self._mask("inner_mouth")
        self.ears = self._mask(*EARS, rounds=6)
        self.sockets = self._mask("eye_socket_left", "eye_socket_right")
        self.nostrils = self._mask("nostril_left", "nostril_right")

    def _find_curves(self) -> None:
        """Distances (P,) of the places to curves; of the brows also how far along them."""
        self.brows = [_along(self.places, self.marks[list(numbers)]) for numbers in _BROWS]
        self.upper = self._lid_distance("upper", UPPER_LID)
        self.lower = self._lid_distance("lower", LOWER_LID)
        self.jaw = _along(self.places, self.marks[_JAW])[0]
        self.chin = _along(self.places, self.marks[[POINT_NAMES["lower_lip"], POINT_NAMES["chin"]]])[0]

    def _find_lips(self) -> None:
        """Distances (P,) of the places to the slit of the mouth and to the outline of the lips, negative inside."""
        inner_upper = self._curve("mouth_inner_upper", UPPER_LIP_INSIDE)
        inner_lower = self._curve("mouth_inner_lower", LOWER_LIP_INSIDE)
        self.slit = np.minimum(_along(self.places, inner_upper)[0], _along(self.places, inner_lower)[0])
        upper = self._curve("mouth_upper", UPPER_LIP)
        lower = self._curve("mouth_lower", LOWER_LIP)
        outline = np.concatenate([upper, lower[::-1]])
        near = np.linalg.norm(self.places - self.marks[MOUTH].mean(0), axis=1) < NEAR_MOUTH
        self.lips = np.full(len(self.places), NEAR_MOUTH)
        self.lips[near] = _signed(self.places[near, :2], outline[:, :2])

    def _mask(self, *names: str, rounds: int = 3) -> np.ndarray:
        """(P,) how far places belong to any of the regions, smoothed over the surface."""
        count = len(self.template.vertices)
        mean = (vertex_neighbours(self.template.faces, count)[1] + sp.identity(count)) / 2
        value = self.template.mask(*names).astype(float)
        for _ in range(rounds):
            value = mean @ value
        return self.weights @ value

    def _curve(self, name: str, numbers: Sequence[int]) -> np.ndarray:
        """A curve (L, 3) of the annotation, or the landmarks that stand for it."""
        curves = self.template.annotation.curves
        return self.surface[curves[name]] if name in curves else self.marks[list(numbers)]

    def _lid_distance(self, part: str, sides: Mapping[str, Sequence[int]]) -> np.ndarray:
        """(P,) to the nearer of both eyes' lids."""
        curves = (self._curve(f"eye_{part}_{side}", numbers) for side, numbers in sides.items())
        return np.minimum(*(_along(self.places, curve)[0] for curve in curves))

    def draw(self, appearance: Appearance) -> np.ndarray:
        """Paint an Appearance. Returns (P, 3) sRGB from 0 to 1."""
        edge = max(0.015 if appearance.flat else 0.05, self.grain)
        waves, phases = appearance.waves
        ripple = np.cos(self.places @ waves.T + phases).mean(1)
        mottle = 0 * ripple if appearance.flat else ripple
        colour = self._skin(appearance, mottle)
        colour = mix(colour, 0.8 * appearance.hair, 0.8 * appearance.stubble * self._beard(appearance, edge))
        colour = self._with_mouth_and_shadow(colour, appearance, edge)
        if appearance.scalp:
            line = self.scalp + 0.12 * np.cos(self.places @ waves[:6].T / 2 + phases[:6]).mean(1)
            strand = appearance.hair * (1 + 0.4 * mottle)[:, None]
            colour = mix(colour, strand, smooth_step(line, 0.5 - 2 * edge, 0.5 + 2 * edge))
        colour = self._with_brows_and_lashes(colour, appearance, edge)
        if appearance.flat:
            grey = colour.mean(1, keepdims=True)
            colour = grey + SATURATION * (colour - grey)
        return to_srgb(colour)

    def _with_mouth_and_shadow(self, colour: np.ndarray, appearance: Appearance, edge: float) -> np.ndarray:
        """Colours with lips, mouth cavity, lipstick and eye shadow. edge: width of a border."""
        if appearance.lipstick is not None:
            lid = smooth_step(self.upper, 0.14, 0.14 - edge if appearance.flat else 0.02) * (self.places[:, 1] > 0.02)
            colour = mix(colour, 0.5 * appearance.lipstick + 0.05, appearance.shadow * lid)
        tone = _pigmented(0.8 * appearance.melanin + 0.04, appearance.blood + 0.9 * appearance.lips)
        tone = tone if appearance.lipstick is None else mix(tone, appearance.lipstick, 0.75)
        colour = mix(colour, tone, smooth_step(self.lips, edge / 2, -edge / 2))
        colour = mix(colour, 0.4 * tone, 0.8 * smooth_step(self.slit, max(0.03, self.grain), 0))
        return mix(colour, CAVITY, smooth_step(self.cavities, 0.2, 0.7))

    def _with_brows_and_lashes(self, colour: np.ndarray, appearance: Appearance, edge: float) -> np.ndarray:
        width, density = appearance.brow
        for distance, share in self.brows:
            thick = width * np.interp(share, [0, 0.2, 0.6, 1], [0.55, 1, 0.8, 0.2])
            colour = mix(colour, 0.7 * appearance.hair, density * smooth_step(distance - thick, edge / 2, -edge / 2))
        for distance, amount in ((self.upper, 1.0), (self.lower, 0.45)):
            size = (0.02 + 0.02 * appearance.lash) * amount**0.5
            dark = amount * appearance.lash * smooth_step(distance - size, edge / 2, -edge / 2)
            colour = mix(colour, 0.15 * appearance.hair, dark)
        return colour

    def _skin(self, appearance: Appearance, mottle: np.ndarray) -> np.ndarray:
        """Linear colours of the skin with its flush, freckles, and the darker skin under the eyes."""
        cheeks, nose, ears = appearance.flush
        marks = self.marks
        flush = cheeks * self._round(marks[np.array(_CHEEKS)].mean(1), 0.2, appearance.flat)
        flush += nose * self._round(marks[[POINT_NAMES["nose_tip"]]], 0.13, appearance.flat)
        flush += ears * smooth_step(self.ears, *((0.45, 0.55) if appearance.flat else (0.1, 0.9)))
        flush += 0.2 * self.nostrils + 0.4 * self.sockets
        melanin = appearance.melanin * (1 + 0.3 * mottle)
        if appearance.spots:
            melanin = melanin + (0.22 + 0.3 * appearance.melanin) * self._freckles(appearance)
        if not appearance.flat:
            melanin = melanin + 0.06 * self._round(marks[list(_BELOW_EYES)] - [0, 0.06, 0], 0.09)
        return _pigmented(melanin, appearance.blood * (1 + mottle) + flush)

    def _round(self, centres: np.ndarray, radius: float, hard: bool = False) -> np.ndarray:
        """Round areas about points, soft or with a clear border."""
        distance = KDTree(centres).query(self.places)[0] / radius
        return smooth_step(distance, 1 + max(self.grain / radius, 0.1), 1.0) if hard else np.exp(-(distance**2))

    def _freckles(self, appearance: Appearance) -> np.ndarray:
        """Small round spots over nose and cheeks."""
        generator = np.random.default_rng(appearance.seed)
        corners = self.surface[self.template.faces]
        middle = corners.mean(1)
        chance = np.linalg.norm(triangle_normals(self.surface, self.template.faces), axis=1)
        chance *= np.exp(
            -((middle[:, 1] - self.marks[list(_BRIDGE_AND_TIP), 1].mean()) ** 2) / 0.03 - (middle[:, 0] / 0.45) ** 2
        )
        chance *= middle[:, 2] > self.marks[list(_EYE_CORNERS), 2].mean() - 0.25
        chosen = generator.choice(len(chance), appearance.spots, p=chance / chance.sum())
        weights = generator.dirichlet([1, 1, 1], appearance.spots)
        sizes = generator.uniform(0.008, 0.017, appearance.spots) * (1.3 if appearance.flat else 1)
        distance, nearest = KDTree((weights[..., None] * corners[chosen]).sum(1)).query(self.places)
        # A spot smaller than the grain of the places is spread over it, and paler for it.
        size = np.maximum(sizes[nearest], self.grain)
        return (sizes[nearest] / size) ** 2 * smooth_step(distance, size + self.grain / 2, size - self.grain)

    def _beard(self, appearance: Appearance, edge: float) -> np.ndarray:
        """Where a beard grows: along the jaw and round the mouth, not higher than the nose."""
        grown = sum(smooth_step(d, far, 0.1) for d, far in ((self.jaw, 0.45), (self.chin, 0.35), (self.lips, 0.28)))
        nose = self.marks[POINT_NAMES["nose_base"], 1]
        grown = np.minimum(grown, 1) * smooth_step(self.places[:, 1], nose + 0.02, nose - 0.12)
        return smooth_step(grown, 0.5 - 2 * edge, 0.5 + 2 * edge) if appearance.flat else grown


def vertex_painter(template: Template) -> AlbedoPainter:
    """The AlbedoPainter whose places are the vertices."""
    return mesh_painter(template, sp.identity(len(template.vertices), format="csr"), template.faces)


def mesh_painter(template: Template, weights: sp.csr_matrix, faces: np.ndarray) -> AlbedoPainter:
    """The AlbedoPainter whose places are the vertices of a mesh over the template.

    weights: (P, V) sparse, what makes them of the template's. faces: (F, 3).
    """
    corners = (weights @ template.vertices)[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return AlbedoPainter(template, weights, float(np.median(edges)))


def random_albedos(template: Template, seed: int, count: int = ALBEDOS) -> np.ndarray:
    """(count, V, 3) uint8 sRGB at the vertices; the same seed gives the same."""
    painter = vertex_painter(template)
    generator = np.random.default_rng(seed)
    return np.stack([to_bytes(painter.draw(random_appearance(generator))) for _ in range(count)])


def _pigmented(melanin: np.ndarray | float, blood: np.ndarray | float) -> np.ndarray:
    """Linear colours (..., 3) of skin with so much of both pigments."""
    absorbed = np.multiply.outer(np.maximum(melanin, 0), MELANIN) + np.multiply.outer(np.maximum(blood, 0), BLOOD)
    return PALE * np.exp(-absorbed)


def _along(points: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance (P,) of points (P, 3) to a polyline (L, 3), and how far along it the nearest place is, from 0 to 1."""
    start = line[:-1]
    step = np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    ends = np.concatenate([[0], np.cumsum(length)])
    best = np.full(len(points), np.inf)
    share = np.zeros(len(points))
    for k in range(len(step)):
        t = np.clip((points - start[k]) @ step[k] / max(length[k] ** 2, 1e-20), 0, 1)
        distance = np.linalg.norm(points - start[k] - t[:, None] * step[k], axis=1)
        nearer = distance < best
        best[nearer] = distance[nearer]
        share[nearer] = (ends[k] + t * length[k])[nearer] / ends[-1]
    return best, share


def _signed(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Distance (P,) of points (P, 2) to a closed outline (L, 2), negative inside."""
    distance = _along(points, np.concatenate([outline, outline[:1]]))[0]
    return np.where(points_in_poly(points, outline), -distance, distance)
