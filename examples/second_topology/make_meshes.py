"""Write a folder of registered OBJ meshes in a topology of its own: a cylindrical scan of random heads.

Usage: python make_meshes.py OUT_DIR [COUNT]. The mesh is a grid of quads around the head, closed at the back, so that
its UV map has a seam there; annotation.json names its landmark vertices. Stands for the meshes that you have.
"""

import sys
from pathlib import Path

import igl
import numpy as np

from caricli.data.identities import random_identity
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import write_json
from caricli.structures import Mesh
from caricli.template.head import load_head

COLUMNS, ROWS = 90, 72
AXIS_DEPTH = 0.03


def scan(vertices, faces):
    """Triangles and barycentric coordinates seen by a scanner that goes around the head, rows bottom to top."""
    angles = 2 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
    around = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], -1)

    def reach(height, direction):
        hits = igl.ray_mesh_intersect(np.array([0.0, height, AXIS_DEPTH]), direction, vertices, faces)
        return max((hit[1] for hit in hits), default=None)

    # The neck is cut lower in front than behind: start where the scanner sees the head from there on upwards.
    levels = np.arange(0.02, 0.06, 0.001)
    seen = np.array([[reach(level, direction) is not None for level in levels] for direction in around])
    bottom = levels[[len(levels) - np.argmin(row[::-1]) if not row.all() else 0 for row in seen]] + 0.002
    points = []
    for share in np.linspace(0, 1, ROWS):
        for direction, low in zip(around, bottom, strict=True):
            height = low + share * (vertices[:, 1].max() - 0.012 - low)
            # A ray can slip through between two triangles; the next one above does not.
            far = next(far for far in (reach(height + k * 2e-4, direction) for k in range(20)) if far is not None)
            points.append(np.array([0.0, height, AXIS_DEPTH]) + far * direction)
    _, triangles, nearest = igl.point_mesh_squared_distance(np.array(points), vertices, faces)
    corners = (np.ascontiguousarray(vertices[faces[triangles, k]]) for k in range(3))
    return triangles, igl.barycentric_coordinates(nearest, *corners)


def grid():
    """Quads around the cylinder, UVs with one column more than vertices, and quads of UV indices."""
    row, column = np.mgrid[0 : ROWS - 1, 0:COLUMNS]
    right = (column + 1) % COLUMNS
    corners = ((row, column), (row, right), (row + 1, right), (row + 1, column))
    quads = np.stack([r * COLUMNS + c for r, c in corners], -1)
    uv_corners = ((row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column))
    uv_quads = np.stack([r * (COLUMNS + 1) + c for r, c in uv_corners], -1)
    uvs = np.stack(np.meshgrid(np.linspace(0, 1, COLUMNS + 1), np.linspace(0, 1, ROWS)), -1).reshape(-1, 2)
    return quads.reshape(-1, 4).astype(np.int32), uvs, uv_quads.reshape(-1, 4).astype(np.int32)


def main():
    """Write the meshes and the annotation."""
    folder, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 40
    folder.mkdir(parents=True, exist_ok=True)
    head, generator = load_head(), np.random.default_rng(0)
    template = head.template()
    triangles, weights = scan(template.vertices, template.faces)
    quads, uvs, uv_quads = grid()

    def sample(vertices):
        return np.einsum("nk,nkd->nd", weights, vertices[template.faces[triangles]])

    for number in range(count):
        acting = {"jawOpen": 0.0, "mouthSmileLeft": generator.uniform(0, 0.8)}
        acting["mouthSmileRight"] = acting["mouthSmileLeft"]
        shape = head.evaluate(**vars(random_identity(head, generator)), actions=acting)
        write_obj(folder / f"scan_{number:03d}.obj", Mesh(sample(shape), quads, uvs, uv_quads))

    points = sample(template.vertices)
    landmarks = [
        int(np.argmin(((points - p) ** 2).sum(1))) for p in template.vertices[template.annotation.landmarks[:68]]
    ]
    # A jaw landmark slides along its own row of the grid, from the ear to the middle of the face.
    paths = []
    for landmark in landmarks[:17]:
        row, column = divmod(landmark, COLUMNS)
        steps = range(column, COLUMNS) if column > COLUMNS // 2 else range(column, -1, -1)
        paths.append([row * COLUMNS + c for c in list(steps)[:10]])
    write_json(folder / "annotation.json", {"ibug68": landmarks, "jaw_paths": paths})


if __name__ == "__main__":
    main()
