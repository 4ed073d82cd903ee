"""Random colours of a head, without light: skin, lips, brows, lashes, stubble, freckles, hair."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree
from skimage.measure import points_in_poly

from caricli.errors import InputError
from caricli.geometry.triangle_normals import triangle_normals
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.render.paint import mix, smooth_step
from caricli.render.uv_map import pad_texture, uv_map
from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    COUNT,
    LOWER_LID,
    LOWER_LIP,
    LOWER_LIP_INSIDE,
    MOUTH,
    UPPER_LID,
    UPPER_LIP,
    UPPER_LIP_INSIDE,
)

STYLES = ("soft", "flat")
"""Painted softly, or in the clear areas of a cartoon."""

# Linear light of skin without pigment, and what each unit of melanin and of blood absorbs of it.
_PALE = np.array([0.95, 0.76, 0.62])
_MELANIN = np.array([2.1, 2.9, 3.8])
_BLOOD = np.array([0.12, 0.85, 0.72])
_DARK_HAIR, _RED_HAIR = np.array([1.15, 1.5, 1.9]), np.array([0.1, 0.75, 1.6])
_CAVITY = np.array([0.16, 0.025, 0.03])
_NEAR_MOUTH = 0.6
_SATURATION = 1.2  # of a cartoon's colours
# Landmarks, where the annotation names no curve; brows from the nose outwards.
_BROWS = (BROW_LEFT, BROW_RIGHT[::-1])
_LIDS = {"upper": UPPER_LID, "lower": LOWER_LID}
_MOUTH = {
    "mouth_upper": UPPER_LIP,
    "mouth_lower": LOWER_LIP,
    "mouth_inner_upper": UPPER_LIP_INSIDE,
    "mouth_inner_lower": LOWER_LIP_INSIDE,
}
_CHEEKS = ((41, 41, 48, 2), (46, 46, 54, 14))


@dataclass(frozen=True)
class Look:
    """What is drawn at random before anything is painted.

    melanin, blood: of the skin. hair: linear RGB. scalp, stubble, flush (of cheeks, nose and ears), lips, lash,
    shadow: strengths from 0 to 1. lipstick: linear RGB, or None. brow: width and density. spots: freckles. waves: of
    the mottled skin, wave vectors, phases. flat: a cartoon's clear areas. seed: of the places of the freckles.
    """

    flat: bool
    melanin: float
    blood: float
    hair: np.ndarray
    scalp: float
    stubble: float
    flush: tuple
    lips: float
    lipstick: np.ndarray | None
    lash: float
    shadow: float
    brow: tuple
    spots: int
    waves: tuple
    seed: int


def random_look(generator, style=None):
    """Draw a Look. generator: numpy Generator. style: of STYLES, or None for either."""
    flat = generator.random() < 0.4 if style is None else style == "flat"
    melanin, blood = generator.beta(1, 1.9), generator.uniform(0.02, 0.35)
    # Dark skin seldom goes with fair hair.
    dark = generator.uniform(0.25, 2.8) + 1.6 * melanin
    hair = 0.8 * np.exp(-dark * _DARK_HAIR - generator.beta(1, 4) * 1.6 * _RED_HAIR)
    if generator.random() < 0.1:
        hair += (0.32 - hair) * generator.uniform(0.4, 0.95)
    if flat and generator.random() < 0.12:
        hair = generator.dirichlet([2, 2, 2]) * 0.6
    bearded, painted = generator.random() < 0.35, generator.random() < 0.4
    lipstick = np.array([generator.uniform(0.3, 0.6), *generator.uniform([0.03, 0.03], [0.1, 0.14])])
    return Look(
        flat=bool(flat),
        melanin=float(melanin),
        blood=float(blood),
        hair=hair,
        scalp=float(generator.random() < 0.75),
        stubble=float(bearded * generator.uniform(0.15, 0.75)),
        flush=tuple(generator.uniform([0.1, 0.1, 0.15], [0.6, 0.5, 0.5]) * (0.8 if flat else 1)),
        lips=float(generator.uniform(0.35, 0.9)),
        lipstick=lipstick if painted and not bearded else None,
        lash=float(generator.uniform(0.5, 1) if flat else generator.uniform(0.3, 0.9)),
        shadow=float((painted and not bearded) * generator.uniform(0, 0.8)),
        brow=tuple(generator.uniform([0.035, 0.55], [0.07, 0.95]) * np.array([1.1 if flat else 1, 1])),
        spots=int((generator.random() < 0.3) * generator.integers(25, 60 if flat else 160)),
        waves=(generator.normal(0, 9, (24, 3)), generator.uniform(0, 2 * np.pi, 24)),
        seed=int(generator.integers(2**32)),
    )


class AlbedoPainter:
    """Places on a head with all that painting must know of them, so that many albedos share it.

    Colours are functions of the place on the surface alone, so that they agree across the seams of the UVs. Lengths are
    in widths of the face between the outer corners of the eyes.
    """

    def __init__(self, template, weights, grain):
        """template: Template. weights: sparse (P, V), the places. grain: metres between neighbouring places."""
        vertices, note = template.vertices, template.annotation
        marks = vertices[note.landmarks[:COUNT]]
        middle, unit = marks[[36, 45]].mean(0), np.linalg.norm(marks[45] - marks[36])
        self.surface, self.faces = (vertices - middle) / unit, template.faces
        self.marks, self.grain = (marks - middle) / unit, grain / unit
        self.places = weights @ self.surface
        mean = (vertex_neighbours(template.faces, len(vertices))[1] + sp.identity(len(vertices))) / 2

        def mask(*names, rounds=3):
            value = template.mask(*names).astype(float)
            for _ in range(rounds):
                value = mean @ value
            return weights @ value

        def curve(name, numbers):
            return self.surface[note.curves[name]] if name in note.curves else self.marks[list(numbers)]

        self.scalp, self.cavities = mask("scalp", rounds=6), mask("inner_mouth")
        self.ears = mask("ear_left", "ear_right", rounds=6)
        self.sockets, self.nostrils = mask("eye_socket_left", "eye_socket_right"), mask("nostril_left", "nostril_right")
        self.brows = [_along(self.places, self.marks[list(numbers)]) for numbers in _BROWS]
        self.upper, self.lower = (
            np.minimum(*(_along(self.places, curve(f"eye_{part}_{side}", n))[0] for side, n in sides.items()))
            for part, sides in _LIDS.items()
        )
        upper, lower, inner_upper, inner_lower = (curve(name, numbers) for name, numbers in _MOUTH.items())
        self.jaw = _along(self.places, self.marks[2:15])[0]
        self.chin = _along(self.places, self.marks[[57, 8]])[0]
        self.slit = np.minimum(_along(self.places, inner_upper)[0], _along(self.places, inner_lower)[0])
        near = np.linalg.norm(self.places - self.marks[MOUTH].mean(0), axis=1) < _NEAR_MOUTH
        outline = np.concatenate([upper, lower[::-1]])
        self.lips = np.full(len(self.places), _NEAR_MOUTH)
        self.lips[near] = _signed(self.places[near, :2], outline[:, :2])

    def draw(self, look):
        """Paint a Look. Returns (P, 3) sRGB from 0 to 1."""
        edge = max(0.015 if look.flat else 0.05, self.grain)
        waves, phases = look.waves
        ripple = np.cos(self.places @ waves.T + phases).mean(1)
        mottle = 0 * ripple if look.flat else ripple
        colour = self._skin(look, mottle)
        colour = mix(colour, 0.8 * look.hair, 0.8 * look.stubble * self._beard(look, edge))
        if look.lipstick is not None:
            lid = smooth_step(self.upper, 0.14, 0.14 - edge if look.flat else 0.02) * (self.places[:, 1] > 0.02)
            colour = mix(colour, 0.5 * look.lipstick + 0.05, look.shadow * lid)
        tone = _pigmented(0.8 * look.melanin + 0.04, look.blood + 0.9 * look.lips)
        tone = tone if look.lipstick is None else mix(tone, look.lipstick, 0.75)
        colour = mix(colour, tone, smooth_step(self.lips, edge / 2, -edge / 2))
        colour = mix(colour, 0.4 * tone, 0.8 * smooth_step(self.slit, max(0.03, self.grain), 0))
        colour = mix(colour, _CAVITY, smooth_step(self.cavities, 0.2, 0.7))
        if look.scalp:
            line = self.scalp + 0.12 * np.cos(self.places @ waves[:6].T / 2 + phases[:6]).mean(1)
            strand = look.hair * (1 + 0.4 * mottle)[:, None]
            colour = mix(colour, strand, smooth_step(line, 0.5 - 2 * edge, 0.5 + 2 * edge))
        width, density = look.brow
        for distance, share in self.brows:
            thick = width * np.interp(share, [0, 0.2, 0.6, 1], [0.55, 1, 0.8, 0.2])
            colour = mix(colour, 0.7 * look.hair, density * smooth_step(distance - thick, edge / 2, -edge / 2))
        for distance, amount in ((self.upper, 1.0), (self.lower, 0.45)):
            size = (0.02 + 0.02 * look.lash) * amount**0.5
            dark = amount * look.lash * smooth_step(distance - size, edge / 2, -edge / 2)
            colour = mix(colour, 0.15 * look.hair, dark)
        if look.flat:
            grey = colour.mean(1, keepdims=True)
            colour = grey + _SATURATION * (colour - grey)
        return _srgb(colour)

    def _skin(self, look, mottle):
        """Linear colours of the skin with its flush, freckles, and the darker skin under the eyes."""
        cheeks, nose, ears = look.flush
        marks = self.marks
        flush = cheeks * self._round(marks[np.array(_CHEEKS)].mean(1), 0.2, look.flat)
        flush += nose * self._round(marks[[30]], 0.13, look.flat)
        flush += ears * smooth_step(self.ears, *((0.45, 0.55) if look.flat else (0.1, 0.9)))
        flush += 0.2 * self.nostrils + 0.4 * self.sockets
        melanin = look.melanin * (1 + 0.3 * mottle)
        if look.spots:
            melanin = melanin + (0.22 + 0.3 * look.melanin) * self._freckles(look)
        if not look.flat:
            melanin = melanin + 0.06 * self._round(marks[[40, 41, 46, 47]] - [0, 0.06, 0], 0.09)
        return _pigmented(melanin, look.blood * (1 + mottle) + flush)

    def _round(self, centres, radius, hard=False):
        """Round areas about points, soft or with a clear border."""
        distance = cKDTree(centres).query(self.places)[0] / radius
        return smooth_step(distance, 1 + max(self.grain / radius, 0.1), 1.0) if hard else np.exp(-(distance**2))

    def _freckles(self, look):
        """Small round spots over nose and cheeks."""
        generator = np.random.default_rng(look.seed)
        corners = self.surface[self.faces]
        middle = corners.mean(1)
        chance = np.linalg.norm(triangle_normals(self.surface, self.faces), axis=1)
        chance *= np.exp(-((middle[:, 1] - self.marks[[28, 30], 1].mean()) ** 2) / 0.03 - (middle[:, 0] / 0.45) ** 2)
        chance *= middle[:, 2] > self.marks[[36, 45], 2].mean() - 0.25
        chosen = generator.choice(len(chance), look.spots, p=chance / chance.sum())
        weights = generator.dirichlet([1, 1, 1], look.spots)
        sizes = generator.uniform(0.008, 0.017, look.spots) * (1.3 if look.flat else 1)
        distance, nearest = cKDTree((weights[..., None] * corners[chosen]).sum(1)).query(self.places)
        # A spot smaller than the grain of the places is spread over it, and paler for it.
        size = np.maximum(sizes[nearest], self.grain)
        return (sizes[nearest] / size) ** 2 * smooth_step(distance, size + self.grain / 2, size - self.grain)

    def _beard(self, look, edge):
        """Where a beard grows: along the jaw and round the mouth, not higher than the nose."""
        grown = sum(smooth_step(d, far, 0.1) for d, far in ((self.jaw, 0.45), (self.chin, 0.35), (self.lips, 0.28)))
        nose = self.marks[33, 1]
        grown = np.minimum(grown, 1) * smooth_step(self.places[:, 1], nose + 0.02, nose - 0.12)
        return smooth_step(grown, 0.5 - 2 * edge, 0.5 + 2 * edge) if look.flat else grown


def albedo_at_vertices(painter, generator, style=None):
    """A random albedo (V, 3) uint8 sRGB of a ``vertex_painter``. style: of STYLES, or None for either."""
    return _bytes(painter.draw(random_look(generator, style)))


def vertex_painter(template):
    """The AlbedoPainter whose places are the vertices."""
    corners = template.vertices[template.faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return AlbedoPainter(template, sp.identity(len(template.vertices), format="csr"), float(np.median(edges)))


def random_albedos(template, seed, count=600):
    """(count, V, 3) uint8 sRGB at the vertices; the same seed gives the same."""
    painter, generator = vertex_painter(template), np.random.default_rng(seed)
    return np.stack([albedo_at_vertices(painter, generator) for _ in range(count)])


class TexturePainter:
    """Random albedos as pictures in the UVs of a template."""

    def __init__(self, template, size):
        """template: Template with UVs. size: texels, width and height. Raises InputError when there are no UVs."""
        if template.uvs is None:
            raise InputError("an albedo needs a template with UVs, found one without")
        face, weights = uv_map(template, size)
        self.covered = face >= 0
        corners, values = template.faces[face[self.covered]], weights[self.covered]
        count = len(corners)
        shape = (count, len(template.vertices))
        matrix = sp.csr_matrix((values.ravel(), corners.ravel(), np.arange(0, 3 * count + 1, 3)), shape)
        area = np.linalg.norm(triangle_normals(template.vertices, template.faces), axis=1).sum() / 2
        self.painter = AlbedoPainter(template, matrix, float(np.sqrt(area / count)))

    def draw(self, look):
        """Paint a Look. Returns (S, S, 3) uint8 sRGB, the top row first."""
        picture = np.zeros((*self.covered.shape, 3), np.uint8)
        picture[self.covered] = _bytes(self.painter.draw(look))
        return pad_texture(picture, self.covered)


def draw_albedo(template, generator, style=None, size=1024):
    """A random albedo of a template with UVs.

    generator: numpy Generator. style: of STYLES, or None for either. size: texels, width and height.
    Returns (size, size, 3) uint8 sRGB, the top row first. Raises InputError when there are no UVs.
    """
    return TexturePainter(template, size).draw(random_look(generator, style))


def _pigmented(melanin, blood):
    """Linear colours (..., 3) of skin with so much of both pigments."""
    absorbed = np.multiply.outer(np.maximum(melanin, 0), _MELANIN) + np.multiply.outer(np.maximum(blood, 0), _BLOOD)
    return _PALE * np.exp(-absorbed)


def _along(points, line):
    """Distance (P,) of points (P, 3) to a polyline (L, 3), and how far along it the nearest place is, from 0 to 1."""
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    ends = np.concatenate([[0], np.cumsum(length)])
    best, share = np.full(len(points), np.inf), np.zeros(len(points))
    for k in range(len(step)):
        t = np.clip((points - start[k]) @ step[k] / max(length[k] ** 2, 1e-20), 0, 1)
        distance = np.linalg.norm(points - start[k] - t[:, None] * step[k], axis=1)
        nearer = distance < best
        best[nearer], share[nearer] = distance[nearer], (ends[k] + t * length[k])[nearer] / ends[-1]
    return best, share


def _signed(points, outline):
    """Distance (P,) of points (P, 2) to a closed outline (L, 2), negative inside."""
    distance = _along(points, np.concatenate([outline, outline[:1]]))[0]
    return np.where(points_in_poly(points, outline), -distance, distance)


def _srgb(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _bytes(colour):
    return np.round(255 * np.clip(colour, 0, 1)).astype(np.uint8)
