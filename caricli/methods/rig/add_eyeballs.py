"""Eyeballs for a rig (portrait paper, section 4.3)."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from caricli.render.paint_eye import paint_eye
from caricli.render.place_eyeballs import place_eyeballs
from caricli.structures import Material, Mesh

RINGS, SECTORS = 14, 24
CLEARANCE = 1.01
ANGLES = {"Up": (-22, 0), "Down": (25, 0), "In": (0, 30), "Out": (0, 30)}
"""How far `eyeLook*` turns an eye, in degrees, about x and about y (towards the nose or away from it)."""

TEXTURE = 512
_AMOUNTS = (0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True)
class Eyeball:
    """side: "left" or "right"; centre (3,) and radius in metres; retreat, how far it was moved in for the lids."""

    side: str
    centre: np.ndarray
    radius: float
    retreat: float


def fit_eyeballs(neutral, deltas, template):
    """Spheres in the eye sockets, so far inside that the lids clear them on the way to every expression.

    neutral: (V, 3). deltas: (K, V, 3). template: Template of the same topology; its annotation knows lids and sockets.
    Returns a list of Eyeball, without the eyes that the annotation does not know.
    """
    annotation, found = template.annotation, []
    balls = place_eyeballs(neutral, template.faces, annotation.curves, annotation.regions)
    for side, (centre, radius) in zip(("left", "right"), balls, strict=False):
        ids = lid_vertices(annotation, side)
        away = moving_vertices(neutral, deltas, ids) - centre
        deep = (CLEARANCE * radius) ** 2 - (away[:, :2] ** 2).sum(1)
        behind = np.where(deep > 0, np.sqrt(np.maximum(deep, 0)) - away[:, 2], 0.0)
        retreat = max(float(behind.max()), 0.0)
        found.append(Eyeball(side, centre - [0, 0, retreat], radius, retreat))
    return found


def lid_vertices(annotation, side):
    """Vertices of the lids of one eye, without the lining of its socket."""
    ids = np.union1d(annotation.curves[f"eye_upper_{side}"], annotation.curves[f"eye_lower_{side}"])
    return np.setdiff1d(np.union1d(ids, annotation.regions[f"eyes_{side}"]), annotation.regions[f"eye_socket_{side}"])


def moving_vertices(neutral, deltas, ids):
    """(N, 3) where vertices are in the neutral face and on the way to every expression."""
    ways = [neutral[ids][None], *(neutral[ids] + amount * deltas[:, ids] for amount in _AMOUNTS)]
    return np.concatenate(ways).reshape(-1, 3)


def add_eyeballs(rig, eyeballs, generator, picture=None):
    """The rig with eyeballs as part of its mesh: own polygons, UVs and picture, turned by the `eyeLook*` shapes.

    rig: Rig with polygons. eyeballs: list of Eyeball. generator: numpy Generator for their picture, where none
    (S, S, 3) is given.
    Returns Rig; the vertices of the face come first.
    """
    if not eyeballs:
        return rig
    points, quads, uvs, uv_quads = _ball()
    uv_start = 1 if rig.mesh.uvs is None else len(rig.mesh.uvs)
    # Every corner needs a place in a picture once the eyes have one.
    known = np.zeros((1, 2)) if rig.mesh.uvs is None else rig.mesh.uvs
    skin_uvs = np.where(rig.mesh.polygons >= 0, 0, -1) if rig.mesh.uvs is None else rig.mesh.uv_polygons
    wide = max(rig.mesh.polygons.shape[1], quads.shape[1])
    polygons, uv_polygons = [_widened(rig.mesh.polygons, wide)], [_widened(skin_uvs, wide)]
    neutral, deltas = [rig.neutral], [rig.deltas]
    for number, ball in enumerate(eyeballs):
        neutral.append(ball.centre + ball.radius * points)
        turned = [ball.radius * (points @ _turn(name, ball.side).T - points) for name in rig.names]
        deltas.append(np.reshape(turned, (len(rig.names), len(points), 3)))
        own, own_uvs = _widened(quads, wide), _widened(uv_quads, wide)
        polygons.append(np.where(own >= 0, own + len(rig.neutral) + number * len(points), -1))
        uv_polygons.append(np.where(own >= 0, own_uvs + uv_start, -1))
    polygons, uv_polygons = (np.concatenate(parts).astype(np.int32) for parts in (polygons, uv_polygons))
    count = len(polygons) - len(eyeballs) * len(quads)
    return replace(
        rig,
        mesh=Mesh(np.concatenate(neutral).astype(np.float32), polygons, np.concatenate([known, uvs]), uv_polygons),
        deltas=np.concatenate(deltas, axis=1).astype(np.float32),
        materials=np.where(np.arange(len(polygons)) < count, Material.SKIN, Material.EYE).astype(np.int32),
        eye_texture=paint_eye(TEXTURE, generator) if picture is None else picture,
    )


def _widened(polygons, width):
    """Rows padded with -1."""
    return np.pad(polygons, ((0, 0), (0, width - polygons.shape[1])), constant_values=-1)


def _turn(name, side):
    """(3, 3) rotation of an eye in an expression; +x is the subject's left."""
    direction = name.removeprefix("eyeLook").lower().removesuffix(side)
    if not name.startswith("eyeLook") or direction.capitalize() not in ANGLES or not name.lower().endswith(side):
        return np.eye(3)
    about_x, about_y = ANGLES[direction.capitalize()]
    inwards = (direction == "in") == (side == "left")
    return Rotation.from_euler("xy", [about_x, -about_y if inwards else about_y], degrees=True).as_matrix()


def _ball():
    """Points (N, 3) of a unit sphere with a pole to the front, quads (Q, 4) padded with -1, UVs (T, 2) and theirs."""
    polar = np.pi * np.arange(1, RINGS) / RINGS
    around = 2 * np.pi * np.arange(SECTORS) / SECTORS
    x, y = np.outer(np.sin(polar), np.cos(around)), np.outer(np.sin(polar), np.sin(around))
    z = np.repeat(np.cos(polar)[:, None], SECTORS, axis=1)
    points = np.concatenate([[[0, 0, 1]], np.stack([x, y, z], -1).reshape(-1, 3), [[0, 0, -1]]])
    # The back is the whole rim of the picture: a place for each of its triangles.
    angles = np.concatenate([np.tile(around, RINGS - 1), around + np.pi / SECTORS])
    reach = np.repeat(np.concatenate([polar, [np.pi]]) / (2 * np.pi), SECTORS)
    uvs = 0.5 + np.concatenate([[[0, 0]], np.stack([reach * np.cos(angles), reach * np.sin(angles)], -1)])
    rings = 1 + np.arange((RINGS - 1) * SECTORS).reshape(RINGS - 1, SECTORS)
    after = np.roll(rings, -1, axis=1)
    none = np.full(SECTORS, -1)
    front = np.column_stack([0 * none, rings[0], after[0], none])
    sides = [np.column_stack([rings[k], rings[k + 1], after[k + 1], after[k]]) for k in range(RINGS - 2)]
    back = np.column_stack([rings[-1], 0 * none + len(points) - 1, after[-1], none])
    quads = np.concatenate([front, *sides, back])
    uv_quads = quads.copy()
    uv_quads[-SECTORS:, 1] += np.arange(SECTORS)
    return points, quads, uvs, uv_quads
