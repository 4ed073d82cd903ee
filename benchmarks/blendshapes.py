"""Optimising blendshapes: seconds.

Usage: python benchmarks/blendshapes.py. Medians of five runs after a warm-up, in seconds of processors. `optimise` is
equation 11 for the neutral and 46 expressions, from the masks to the last solution, on the head and on a mesh of about
5,500 vertices, decimated from the subdivided head; `build` everything from landmarks to shapes, contacts included. The
last line is JSON. The paper needs about a second for its shape component.
"""

import json

import igl
import numpy as np
from portrait import median

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.optimise_blendshapes import optimise_blendshapes
from caricli.store.expression_tools import load_tools
from caricli.structures import Camera, Face, Mesh
from caricli.template.fine_mesh import fine_mesh

SIZES = (4_200, 5_500)


def main():
    """Print the figures and the JSON line."""
    tools, _ = load_tools()
    template, moves = tools.morphable.template, tools.templates.deltas
    seconds = {f"optimise {count} vertices": optimised(template, moves, count) for count in SIZES}
    (caricature,) = exaggerate_curvature(template.vertices, template.faces, [0.2])
    camera = Camera(1600.0, head_rotation(np.array([0.05, 0.2, 0])), np.array([300.0, 300]))
    face = Face(template.with_vertices(caricature), camera)
    seconds["build 4200 vertices"] = median(lambda: build_blendshapes(face, tools))
    for name, value in seconds.items():
        print(f"{name}: {value:.3f} s")
    print(json.dumps({"seconds": seconds}))


def optimised(template, moves, count):
    """Seconds for displacements (K, V, 3), a tenth larger than those of the normal face, on about so many vertices."""
    mesh = template
    if count > len(template.vertices):
        fine = fine_mesh(template, 1)
        faces = np.asarray(fine.mesh.faces, dtype=np.int32)
        ratio = int(len(faces) * count / len(fine.mesh.vertices))
        vertices, faces, _, born = igl.decimate(fine.mesh.vertices, faces, ratio)
        mesh = Mesh(vertices, faces)
        moves = np.stack([fine.weights @ move for move in moves])[:, born]
    return median(lambda: optimise_blendshapes(1.1 * moves, moves, mesh))


if __name__ == "__main__":
    main()
