"""Hair, hats and beards that people wear in pictures."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.polar_quads import polar_quads
from caricli.geometry.smooth_step import smooth_step
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.pictures.background import random_colour
from caricli.methods.pictures.piece import Piece, make_piece, seen_from_both_sides
from caricli.methods.pictures.settings import SitterSettings
from caricli.structures.parsing import Region

COLUMNS = 72
ROWS = 22
"""Of quads of a shell, around the head and from the whorl to its edge."""


@dataclass(frozen=True)
class HatShape:
    """Something worn on the head; angles are degrees from the whorl, lengths shares of the head's height.

    front, sides, back: where it ends over the forehead, beside the face and behind, between. crown: how far it stands
    above the head, between. brim: chance of one. walls: whether they are upright, below a flat top. falls: whether it
    falls straight from where the head is widest. folds: whether it is uneven.
    """

    front: tuple[float, float] = (48, 74)
    sides: tuple[float, float] = (62, 92)
    back: tuple[float, float] = (70, 108)
    crown: tuple[float, float] = (0.0, 0.1)
    brim: float = 0.0
    walls: bool = False
    falls: bool = False
    folds: bool = False


HATS = {
    "cap": HatShape(brim=1),
    "hat": HatShape(crown=(0.1, 0.4), brim=1),
    "beanie": HatShape(crown=(0.0, 0.25)),
    "top hat": HatShape(crown=(0.05, 0.6), brim=0.7, walls=True),
    "hood": HatShape((46, 66), (98, 140), (130, 152), (0.0, 0.12), falls=True, folds=True),
    "turban": HatShape((50, 70), (66, 96), (80, 112), (0.05, 0.3), folds=True),
}
"""By name."""

_WALLS = (0.15, 0.75)
"""Heights on the unit sphere between which walls of a hat stand; above them is its top."""

_UNDER = 0.01  # of the head's height: how far below the skin a shell ends
_STRANDS = 3.0  # pictures of strands around a head


def random_wig(
    sphere: HeadSphere, colour: np.ndarray, generator: np.random.Generator, settings: SitterSettings
) -> tuple[Piece, np.ndarray]:
    """Draw a head of hair: short, a bob or long, with a fringe or without, smooth or curly.

    colour: linear light. Returns a Piece, and how thick hair is on a map (R, C) of the sphere, metres.
    """
    height = sphere.head.height
    fringe, sides, back = (generator.uniform(*limits) for limits in (settings.fringe, settings.sides, settings.back))
    edge = np.radians(np.interp(_away(sphere.longitudes), [0, 0.28, 0.5, 1], [fringe, fringe + 4, sides, back]))
    parting = generator.uniform(-0.5, 0.5)
    edge += np.radians(generator.uniform(0, 16)) * np.sin(sphere.longitudes - parting) * (_front(sphere) > 0)
    edge += np.radians(generator.uniform(0, 5)) * np.sin(generator.integers(5, 25) * sphere.longitudes)
    thick = generator.uniform(*settings.thickness) * height
    curls = generator.uniform(0, 0.35) if generator.random() < 0.5 else 0.0
    lumps = _lumps(sphere, generator)
    thickness = thick * np.maximum(0.4 + 0.6 * np.cos(sphere.angles / 1.6)[:, None], 0.25) * (1 + curls * lumps)
    total = _fall(sphere, sphere.radii + thickness)
    tone = colour * generator.uniform(0.6, 1.25)
    return _shell(sphere, total, edge, Region.HAIR, tone, generator.uniform(0.05, 0.3)), total - sphere.radii


def random_hat(sphere: HeadSphere, thickness: np.ndarray | float, generator: np.random.Generator) -> list[Piece]:
    """Draw something worn on the head, of one of HATS. thickness: of the hair below it, metres."""
    height = sphere.head.height
    kind = str(generator.choice(list(HATS)))
    shape = HATS[kind]
    front, sides, back = (np.radians(generator.uniform(*limits)) for limits in (shape.front, shape.sides, shape.back))
    edge = np.interp(_away(sphere.longitudes), [0, 0.2, 0.5, 1], [front, front + 0.1 * (sides - front), sides, back])
    crown = height * generator.uniform(*shape.crown)
    up = np.clip(_ways(sphere)[..., 1], 0, 1)
    total = sphere.radii + thickness + 0.02 * height
    total = _fall(sphere, total) if shape.falls else total
    total = _walled(total, crown, up, generator) if shape.walls else total + crown * up**2
    if shape.folds:
        total = total * (1 + generator.uniform(0.01, 0.05) * _lumps(sphere, generator))
    colour = random_colour(generator)
    shell = _shell(sphere, total, edge, Region.HAT, colour, 0.05)
    colours = _trimmed(shell.colours, generator)
    pieces = [replace(shell, strands=np.full_like(shell.strands, np.nan), colours=colours)]
    if generator.random() < shape.brim:
        reach = height * generator.uniform(0.12, 0.4)
        ahead = np.clip(1.3 * _front(sphere), 0, 1) ** 0.5 if kind == "cap" else np.ones_like(_front(sphere))
        pieces.append(_brim(sphere, total, edge, reach * ahead, colour * generator.uniform(0.6, 1.0)))
    return pieces


def _walled(total: np.ndarray, crown: float, up: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Radii of a hat with upright walls and a flat top that stands a crown, metres, above the head.

    total: (R, C) radii without it. up: (R, C) height of unit vectors.
    """
    across = np.sqrt(np.maximum(1 - up**2, 1e-6))
    low, high_up = _WALLS
    wide = np.where((up > low) & (up < high_up), total * across, 0).max() * generator.uniform(0.9, 1.1)
    high = (total * up).max() + crown
    walls = np.minimum(wide / across, high / np.maximum(up, 1e-6))
    return np.where(up > low, np.maximum(total, walls), total)


def _trimmed(colours: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Colours (W, 3) of a shell plain, with a band around its edge, or striped."""
    other = random_colour(generator)
    rings = colours[1:].reshape(ROWS, COLUMNS, 3).copy()
    kind = generator.random()
    if kind < 0.35:
        rings[ROWS - int(generator.integers(3, 8)) : ROWS] = other
    elif kind < 0.5:
        width = int(generator.choice([3, 6, 9, 12]))
        rings[:, (np.arange(COLUMNS) // width) % 2 == 0] = other
    return np.concatenate([colours[:1], rings.reshape(-1, 3)])


def random_beard(
    skin: Piece, normals: np.ndarray, grown: np.ndarray, colour: np.ndarray, thickness: float
) -> Piece | None:
    """A beard that stands off the skin where it grows.

    skin: Piece. normals: (W, 3). grown: (W,) from 0 to 1. thickness: metres.
    Returns a Piece, None where nothing grows.
    """
    faces = skin.faces[(grown[skin.faces] > 0.05).all(1)]
    if not len(faces):
        return None
    hanging = np.array([0, -0.6, 0.2])
    lift = thickness * smooth_step(grown, 0.05, 0.9)
    vertices = skin.vertices + lift[:, None] * (normals + hanging) - 0.1 * thickness * normals
    used, numbers = np.unique(faces, return_inverse=True)
    size = np.ptp(skin.vertices[:, 1])
    strands = np.stack([vertices[used, 0] / size * 9, vertices[used, 1] / size * 2], 1)
    return make_piece(vertices[used], numbers.reshape(-1, 3), Region.BEARD, colour, 0.05, strands)


def _away(longitudes: np.ndarray) -> np.ndarray:
    """How far directions are from the face around the whorl, 0 to 1."""
    return np.abs((longitudes + np.pi) % (2 * np.pi) - np.pi) / np.pi


def _front(sphere: HeadSphere) -> np.ndarray:
    """(C,) how far longitudes look to where the face looks, -1 to 1."""
    return np.cos(sphere.longitudes)


def _ways(sphere: HeadSphere) -> np.ndarray:
    """(R, C, 3) directions of the sphere's grid in the axes of the face."""
    return sphere.directions(*np.meshgrid(sphere.longitudes, sphere.angles))


def _lumps(sphere: HeadSphere, generator: np.random.Generator) -> np.ndarray:
    """(R, C) smooth noise on the sphere."""
    ways = _ways(sphere)
    waves = generator.normal(0, 9, (12, 3))
    return np.cos(ways @ waves.T + generator.uniform(0, 2 * np.pi, 12)).mean(-1) * np.sqrt(12 * 2) / 2


def _fall(sphere: HeadSphere, total: np.ndarray) -> np.ndarray:
    """Radii with which hair falls straight from where the head is widest, and does not follow the neck."""
    ways = _ways(sphere)
    aside = np.hypot(ways[..., 0], np.minimum(ways[..., 2], 0))
    widest = np.maximum.accumulate(np.where(ways[..., 1] > -0.1, total * aside, 0), axis=0)
    low = (ways[..., 1] < -0.05) & (ways[..., 2] < 0.45)
    return np.where(low, np.maximum(total, 0.96 * widest / np.maximum(aside, 0.35)), total)


def _shell(
    sphere: HeadSphere, total: np.ndarray, edge: np.ndarray, region: Region, colour: np.ndarray, gloss: float
) -> Piece:
    """A surface from the whorl to an edge (C,) of the sphere, its radii (R, C), closing towards the skin there."""
    turns = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    ends = np.interp(turns, sphere.longitudes, edge, period=2 * np.pi)
    share = np.sin(np.pi / 2 * np.arange(1, ROWS + 1) / ROWS)
    angles = share[:, None] * ends
    around = np.broadcast_to(turns, angles.shape)
    skin = sphere.sample(sphere.radii, around, angles)
    thickness = sphere.sample(total, around, angles) - skin
    left = (1 - share)[:, None] * ends / np.radians(14)
    radii = skin + thickness * np.sqrt(np.clip(left, 0, 1))
    radii[-1] = skin[-1] - _UNDER * sphere.head.height
    top = sphere.points(np.zeros(1), np.zeros(1), sphere.sample(total, np.zeros(1), np.zeros(1)))
    points = np.concatenate([top, sphere.points(around, angles, radii).reshape(-1, 3)])
    across = np.append(0, np.broadcast_to(_STRANDS * np.arange(COLUMNS) / COLUMNS, angles.shape).ravel())
    strands = np.stack([across, np.append(0, np.repeat(share, COLUMNS))], 1)
    return make_piece(points, _net(), region, colour, gloss, strands)


def _brim(sphere: HeadSphere, total: np.ndarray, edge: np.ndarray, reach: np.ndarray, colour: np.ndarray) -> Piece:
    """A ring that leaves an edge (C,) of a hat outwards, so far (C,), metres."""
    inside = sphere.points(sphere.longitudes, edge, 0.97 * sphere.sample(total, sphere.longitudes, edge))
    outward = inside - sphere.middle
    outward[:, 1] = 0
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
    outside = inside + reach[:, None] * (outward + [0, -0.18, 0])
    count = len(edge)
    ring = np.arange(count)
    after = np.roll(ring, -1)
    quads = np.stack([ring, ring + count, after + count, after], 1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return seen_from_both_sides(make_piece(np.concatenate([inside, outside]), faces, Region.HAT, colour))


def _net() -> np.ndarray:
    """Triangles of a shell: the fan at its whorl and the first half of every quad, then the second halves."""
    quads = polar_quads(ROWS, COLUMNS)
    return np.concatenate([quads[:, :3], quads[COLUMNS:, [0, 2, 3]]])
