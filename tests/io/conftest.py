"""A rig with all that files hold: quads, UVs with a seam, two materials and pictures."""

import numpy as np
import pytest

from caricli.structures import Material, Mesh, Pictures, Rig

ROWS, COLUMNS = 5, 8


def band(radius, centre):
    """A closed band of quads around the y axis, outside out: points, quads, UVs and UV quads; the seam in column 0."""
    turn, height = np.meshgrid(2 * np.pi * np.arange(COLUMNS) / COLUMNS, np.linspace(-0.8, 0.8, ROWS + 1))
    points = np.stack([np.sin(turn), height, np.cos(turn)], axis=-1).reshape(-1, 3) * radius + centre
    row, column = (a.ravel() for a in np.mgrid[:ROWS, :COLUMNS])

    def quads(width, following):
        below = row * width + column
        after = row * width + following
        return np.stack([below, after, after + width, below + width], axis=1)

    u, v = np.meshgrid(np.arange(COLUMNS + 1) / COLUMNS, np.arange(ROWS + 1) / ROWS)
    uvs = np.stack([u.ravel(), 0.25 + v.ravel() / 2], axis=1)
    return points, quads(COLUMNS, (column + 1) % COLUMNS), uvs, quads(COLUMNS + 1, column + 1)


@pytest.fixture(scope="session")
def full_rig():
    """A face and an eye; one shape moves the face's lowest row, one all of it, one the eye, one nothing."""
    skin, eye = band(0.12, [0, 0.1, 0]), band(0.02, [0.03, 0.12, 0.12])
    count, uv_count = len(skin[0]), len(skin[2])
    polygons = np.concatenate([skin[1], eye[1] + count]).astype(np.int32)
    uv_polygons = np.concatenate([skin[3], eye[3] + uv_count]).astype(np.int32)
    neutral = np.concatenate([skin[0], eye[0]]).astype(np.float32)
    deltas = np.zeros((4, *neutral.shape), np.float32)
    deltas[0, :COLUMNS] = [0, -0.01, 0.02]
    deltas[1, :count] = np.random.default_rng(3).normal(0, 0.003, (count, 3))
    deltas[2, count:, 2] = 0.001
    pictures = np.random.default_rng(4).integers(0, 256, (2, 16, 16, 3), np.uint8)
    return Rig(
        names=("jawOpen", "mouthSmileLeft", "eyeLookUpLeft", "tongueOut"),
        mesh=Mesh(neutral, polygons, np.concatenate([skin[2], eye[2]]), uv_polygons),
        deltas=deltas,
        materials=np.repeat([Material.SKIN, Material.EYE], [len(skin[1]), len(eye[1])]).astype(np.int32),
        pictures=Pictures(*pictures),
    )
