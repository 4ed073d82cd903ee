"""What stands out in a person made more of, and the rest less."""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.template.template import Template

STRETCHES = slice(3, 6)
"""Of the features of ``DeformationGradients``: the stretches along the three axes, minus one."""

LIDS = ("eyes_left", "eyes_right", "eye_socket_left", "eye_socket_right")
"""Regions that are never made more of: lids that go further than closed go through each other."""

CALM = ("scalp", "neck")
"""Regions that are made less of: their large triangles would drown what happens in the face."""


@dataclass(frozen=True)
class GrowthSettings:
    """How a person's own features are exaggerated.

    Lengths are shares of the head's height. near: over which differences are taken together, 7 mm; around: over which
    what grew takes room, about a nose's length. crowd: of the growth around it, what a place loses, but never more
    than most_room. most: a difference grows by no more than this factor. calm: share of all this that scalp and neck
    are spared. lively: natural logarithm of how much more an expression moves what is one deviation larger than usual.
    calmest, liveliest: bounds in these deviations.
    """

    near: float = 0.03
    around: float = 0.18
    crowd: float = 2.0
    most_room: float = 0.25
    most: float = 3.5
    calm: float = 0.85
    lively: float = 0.5
    calmest: float = -1.5
    liveliest: float = 1.2


@dataclass(frozen=True)
class WhimSettings:
    """How a caricaturist's whims are drawn.

    strength, power: uniform from low to high, see Whim. attention, size, temper: standard deviations of their fields,
    of logarithms. Lengths are correlation lengths of fields, shares of the head's height: part_length of the sizes
    that are the same along all axes, as of a nose, breadth_length of those along each, as of a jaw. parts: share of
    the variance of sizes that the former have. sides, temper_sides: share of a field's variance that tells left from
    right. smallest, largest: bounds of the sizes' logarithms. waves: in a field.
    """

    strength: tuple[float, float] = (1.3, 3.0)
    power: tuple[float, float] = (0.7, 1.5)
    attention: float = 0.6
    attention_length: float = 0.08
    sides: float = 0.3
    size: float = 0.3
    part_length: float = 0.08
    breadth_length: float = 0.12
    parts: float = 0.6
    smallest: float = -0.7
    largest: float = 0.8
    temper: float = 0.7
    temper_length: float = 0.15
    temper_sides: float = 0.6
    waves: int = 40


@dataclass(frozen=True, eq=False)
class Whim:
    """What a caricaturist makes of a face.

    strength: factor of the differences of a person as unusual everywhere as here. power: of how unusual the person is
    in a place that the factor grows with; above 0 exaggeration is more than in proportion. attention: (V,) factors of
    how unusual a place looks. sizes: (V, 3) logarithms of factors along the axes that nothing in the person asks for.
    temper: (V,) added to how much larger than usual a place is, where expressions move it.
    """

    strength: float
    power: float
    attention: np.ndarray
    sizes: np.ndarray
    temper: np.ndarray


GROWTH = GrowthSettings()
WHIM = WhimSettings()


class UsualFace:
    """What neutral faces usually are, and how much they usually differ, at every vertex."""

    def __init__(self, template: Template, mean: np.ndarray, deviation: np.ndarray) -> None:
        """mean, deviation: (V, 9) of the features of neutral faces."""
        self.gradients = template.gradients
        self.mean = mean
        self.mass = igl.massmatrix(template.vertices, template.faces).diagonal()
        self._laplacian = -igl.cotmatrix(template.vertices, template.faces)
        self._near = self._diffusion(GROWTH.near * template.height)
        self._around = self._diffusion(GROWTH.around * template.height)
        self.difference = np.sqrt(self.near(np.square(deviation).sum(1)))
        self.growth = np.sqrt(self.near(np.square(deviation[:, STRETCHES]).mean(1)))
        self.calm = GROWTH.calm * np.clip(self.near(template.mask(*CALM).astype(float)), 0, 1)
        self.lids = np.clip(self.near(template.mask(*LIDS).astype(float)), 0, 1)

    def _diffusion(self, length: float) -> Cholesky:
        return Cholesky(sp.diags(self.mass) + length**2 / 2 * self._laplacian)

    def near(self, values: np.ndarray) -> np.ndarray:
        """Means (V,) of values (V,) over a part of a part of the face."""
        return self._near.solve((self.mass * values)[:, None])[:, 0]

    def around(self, values: np.ndarray) -> np.ndarray:
        """Means (V,) of values (V,) over a part of the face and what lies around it."""
        return self._around.solve((self.mass * values)[:, None])[:, 0]


def exaggerate_own(vertices: np.ndarray, neutral: np.ndarray, whim: Whim, usual: UsualFace) -> np.ndarray:
    """Exaggerate a person by what tells this one from others, place by place.

    In the features of deformation gradients a place differs from the usual face by d, which is z times as much as
    places there usually do. With w = z * attention, of mean square one over the head, d becomes ``strength w^power d``:
    what stands out grows more than in proportion, at the cost of all else, and what is usual vanishes. What grew takes
    room from its surroundings. The expression's own features move more what has grown, and less what shrank.

    vertices, neutral: (V, 3) metres, the person with and without an expression.
    Returns (V, 3), not aligned; a few triangles may be flipped.
    """
    own = usual.gradients.features(neutral)
    difference = own - usual.mean
    features = _grown(difference, whim, usual)
    growth = (features - difference)[:, STRETCHES].mean(1)
    features[:, STRETCHES] -= _room(growth, usual)[:, None]
    larger = usual.near(features[:, STRETCHES].mean(1)) / usual.growth + whim.temper
    lively = np.exp(GROWTH.lively * np.clip(larger, GROWTH.calmest, GROWTH.liveliest))
    lively += usual.lids * (1 - lively)
    expression = usual.gradients.features(vertices) - own
    return usual.gradients.vertices_like(usual.mean + features + lively[:, None] * expression, vertices)


def _room(growth: np.ndarray, usual: UsualFace) -> np.ndarray:
    """(V,) what the surroundings of what grew lose, and gain of what shrank. growth: (V,) of the stretches."""
    taken = usual.around(growth)
    sign = np.sign(taken)
    # Not what itself has grown as much: what it takes is for itself.
    room = GROWTH.crowd * sign * np.clip(sign * (taken - usual.near(growth)), 0, np.abs(taken))
    return GROWTH.most_room * np.tanh(room / GROWTH.most_room)


def _grown(difference: np.ndarray, whim: Whim, usual: UsualFace) -> np.ndarray:
    """Differences (V, 9) from the usual face, exaggerated."""
    unusual = np.sqrt(np.maximum(usual.near(np.square(difference).sum(1)), 0)) / usual.difference * whim.attention
    mean_square = usual.mass @ unusual**2 / usual.mass.sum()
    factor = whim.strength * (unusual / np.sqrt(max(mean_square, 1e-12))) ** whim.power
    factor = GROWTH.most * np.tanh(factor / GROWTH.most)
    factor += usual.calm * (1 - factor)
    factor += usual.lids * (np.minimum(factor, 1) - factor)
    grown = factor[:, None] * difference
    grown[:, STRETCHES] += np.expm1(whim.sizes * ((1 - usual.lids) * (1 - usual.calm))[:, None])
    return grown


def random_whim(vertices: np.ndarray, height: float, generator: np.random.Generator, mildness: float = 1.0) -> Whim:
    """Draw what a caricaturist makes of a face.

    vertices: (V, 3) metres, of the template; its plane x = 0 tells left from right. height: of the head, metres.
    mildness: multiplies strength and sizes.
    """
    places = vertices / height

    def field(length: float, sides: float) -> np.ndarray:
        return random_field(places / length, sides, generator)

    strength = generator.uniform(*WHIM.strength)
    power = generator.uniform(*WHIM.power)
    attention = np.exp(WHIM.attention * field(WHIM.attention_length, WHIM.sides))
    part = np.sqrt(WHIM.parts) * field(WHIM.part_length, WHIM.sides)
    axes = [part + np.sqrt(1 - WHIM.parts) * field(WHIM.breadth_length, WHIM.sides) for _ in range(3)]
    sizes = np.stack(axes, axis=1)
    # Squared, of variance one again: few places are bold, most are left alone.
    sizes = np.clip(WHIM.size * sizes * np.abs(sizes) / np.sqrt(3), WHIM.smallest, WHIM.largest)
    temper = WHIM.temper * field(WHIM.temper_length, WHIM.temper_sides)
    return Whim(mildness * strength, power, attention, mildness * sizes, temper)


def random_field(places: np.ndarray, sides: float, generator: np.random.Generator) -> np.ndarray:
    """Draw a smooth field of variance one with the correlation ``exp(-|p - q|^2 / 2)`` (Rahimi and Recht 2007).

    places: (V, 3) in correlation lengths. sides: share of the variance that changes its sign with x.
    Returns (V,).
    """
    frequencies = generator.normal(size=(3, WHIM.waves))
    phases = generator.uniform(0, 2 * np.pi, WHIM.waves)
    own, other = (np.cos(side @ frequencies + phases).mean(1) for side in (places, places * [-1, 1, 1]))
    scale = np.sqrt(2 * WHIM.waves)
    return scale * (np.sqrt((1 - sides) / 2) * (own + other) + np.sqrt(sides / 2) * (own - other))
