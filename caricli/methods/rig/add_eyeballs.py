"""Eyeballs for a rig (portrait paper, section 4.3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.polar_quads import polar_quads
from caricli.methods.rig.add_parts import add_parts
from caricli.render.eyes.paint_eye import paint_eye
from caricli.render.eyes.place_eyeballs import place_eyeball
from caricli.structures import Material, Mesh, Part, Rig
from caricli.structures.arkit import ARKIT_NAMES, action_codes, alone
from caricli.template.annotation import Annotation

RINGS = 14
"""Rows of polygons from the front of an eyeball to its back."""

SECTORS = 24
"""Polygons around an eyeball."""

CLEARANCE = 1.01
"""Of an eyeball's radius: how far the lids stay from its centre."""

ANGLES = {"Up": (-22, 0), "Down": (25, 0), "In": (0, 30), "Out": (0, 30)}
"""How far `eyeLook*` turns an eye, in degrees, about x and about y (towards the nose or away from it)."""

TEXTURE = 512
"""Side of the picture of an eye, pixels."""

_AMOUNTS = (0.25, 0.5, 0.75, 1.0)
"""Weights at which lids on their way through an expression are looked at."""


@dataclass(frozen=True)
class Eyeball:
    """side: "left" or "right"; centre (3,) and radius in metres; retreat, how far it was moved in for the lids."""

    side: str
    centre: np.ndarray
    radius: float
    retreat: float


def fit_eyeballs(mesh: Mesh, annotation: Annotation, deltas: np.ndarray) -> list[Eyeball]:
    """Spheres in the eye sockets, so far inside that the lids clear them on the way to every expression.

    mesh: Mesh of the neutral face, metres. annotation: of its topology; it knows lids and sockets. deltas: (K, V, 3).
    Returns them without the eyes that the annotation does not know.
    """
    eyeballs = []
    for side in ("left", "right"):
        placed = place_eyeball(mesh, annotation, side)
        if placed is None:
            continue
        centre, radius = placed
        ids = lid_vertices(annotation, side)
        away = moving_vertices(mesh.vertices, deltas, ids) - centre
        deep = (CLEARANCE * radius) ** 2 - (away[:, :2] ** 2).sum(1)
        behind = np.where(deep > 0, np.sqrt(np.maximum(deep, 0)) - away[:, 2], 0.0)
        retreat = float(behind.max(initial=0.0))
        eyeballs.append(Eyeball(side, centre - [0, 0, retreat], radius, retreat))
    return eyeballs


def lid_vertices(annotation: Annotation, side: str) -> np.ndarray:
    """Vertices of the lids of one eye, of their margins alone where they have no region, and none of its socket.

    Where a socket reaches to the margins and nothing else is lid, they are all that is.
    """
    margins = np.concatenate([annotation.curves[f"eye_upper_{side}"], annotation.curves[f"eye_lower_{side}"]])
    lids = np.append(margins, annotation.regions.get(f"eyes_{side}", margins))
    outside = np.setdiff1d(lids, annotation.regions[f"eye_socket_{side}"])
    return outside if len(outside) else np.unique(margins)


def moving_vertices(neutral: np.ndarray, deltas: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """(N, 3) where vertices are in the neutral face and on the way to every expression."""
    ways = [neutral[ids][None], *(neutral[ids] + amount * deltas[:, ids] for amount in _AMOUNTS)]
    return np.concatenate(ways).reshape(-1, 3)


def add_eyeballs(
    rig: Rig, eyeballs: Sequence[Eyeball], generator: np.random.Generator, picture: np.ndarray | None = None
) -> Rig:
    """The rig with eyeballs as part of its mesh: own polygons, UVs and picture, turned by the `eyeLook*` actions.

    generator: of their picture, where none (S, S, 3) is given.
    Returns Rig; the vertices of the face come first.
    """
    if not eyeballs:
        return rig
    ball = _unit_ball()
    materials = np.full(len(ball.polygons), Material.EYE, np.int32)
    codes = action_codes([*alone(rig.names).values()]) if rig.actions is None else rig.actions
    turns = [eye_turns(dict(zip(ARKIT_NAMES, code.tolist(), strict=True))) for code in codes]
    parts = []
    for each in eyeballs:
        row = 0 if each.side == "left" else 1
        turned = [each.radius * (ball.vertices @ _rotation(turn[row]).T - ball.vertices) for turn in turns]
        deltas = np.reshape(turned, (len(rig.names), *ball.vertices.shape))
        placed = ball.with_vertices(each.centre + each.radius * ball.vertices)
        parts.append(Part(f"eye_{each.side}", placed, materials, "skull", rig.names, deltas))
    eyes = paint_eye(TEXTURE, generator) if picture is None else picture
    return replace(add_parts(rig, parts), pictures=replace(rig.pictures, eyes=eyes))


def eye_turns(weights: Mapping[str, float]) -> np.ndarray:
    """(2, 2) radians, of the left and the right eye about y, to the subject's left, and about x, down.

    weights: of ARKit's actions, by name.
    """
    turns = np.zeros((2, 2))
    for row, (side, mirror) in enumerate((("Left", 1), ("Right", -1))):
        for way, (about_x, about_y) in ANGLES.items():
            aside = -mirror * about_y if way == "In" else mirror * about_y
            turns[row] += weights.get(f"eyeLook{way}{side}", 0) * np.array([aside, about_x])
    return np.radians(turns)


def _rotation(turn: np.ndarray) -> np.ndarray:
    """(3, 3) of an eye that is turned (2,) radians about y and x."""
    aside, down = turn
    return rotation_matrices(np.array([0, aside, 0])) @ rotation_matrices(np.array([down, 0, 0]))


def _unit_ball() -> Mesh:
    """A unit sphere of quads, with triangles at its poles; its picture is unrolled from the one in front."""
    polar = np.pi * np.arange(1, RINGS) / RINGS
    around = 2 * np.pi * np.arange(SECTORS) / SECTORS
    x = np.outer(np.sin(polar), np.cos(around))
    y = np.outer(np.sin(polar), np.sin(around))
    z = np.repeat(np.cos(polar)[:, None], SECTORS, axis=1)
    points = np.concatenate([[[0, 0, 1]], np.stack([x, y, z], -1).reshape(-1, 3), [[0, 0, -1]]])
    # The back is the whole rim of the picture: a place for each of its triangles.
    angles = np.concatenate([np.tile(around, RINGS - 1), around + np.pi / SECTORS])
    reach = np.repeat(np.concatenate([polar, [np.pi]]) / (2 * np.pi), SECTORS)
    uvs = 0.5 + np.concatenate([[[0, 0]], np.stack([reach * np.cos(angles), reach * np.sin(angles)], -1)])
    rim = len(points) - 1 - SECTORS + np.arange(SECTORS)
    back = np.column_stack([rim, np.full(SECTORS, len(points) - 1), np.roll(rim, -1), np.full(SECTORS, -1)])
    quads = np.concatenate([polar_quads(RINGS - 1, SECTORS), back])
    uv_quads = quads.copy()
    uv_quads[-SECTORS:, 1] += np.arange(SECTORS)
    return Mesh(points, quads, uvs, uv_quads)
