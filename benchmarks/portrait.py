"""Refining and texturing faces: seconds.

Usage: python benchmarks/portrait.py. Medians of five runs after a warm-up, in seconds of processors, so that other work
on the machine does not count and more cores do not help. `refine` is its Laplacian deformation with 68 anchors, from
the factorisation to the last round of rotations: at the size of the head, and at the 35,709 vertices of the paper,
decimated from the twice subdivided head. The texture has 1024 texels a side, of a rendered portrait of 512 pixels. The
last line is JSON. The paper needs 20.02 s for a refinement.
"""

import json
import statistics
import time

import igl
import numpy as np

from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation
from caricli.methods.evaluate.portrait_studio import PortraitStudio
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.texture_face import texture_face
from caricli.structures.landmarks import COUNT
from caricli.template.fine_mesh import fine_mesh
from caricli.template.head import load_head

RUNS = 5
"""Of which the median is taken."""

SIZES = (4_200, 35_709)
"""Vertices: the head's, and the paper's."""

TEXTURE = 1024
"""Texels a side."""

PICTURE = 512
"""Pixels a side."""

PUSH = 0.004
"""Metres, standard deviation of how far a landmark is moved."""


def main():
    """Print the three figures and the JSON line."""
    template = load_head().template()
    seconds = {f"refine {count} vertices": time_refining(template, count) for count in SIZES}
    seconds[f"texture {TEXTURE} texels"] = time_texturing(template)
    for name, value in seconds.items():
        print(f"{name}: {value:.3f} s")
    print(json.dumps({"seconds": seconds}))


def time_refining(template, count):
    """Seconds to factor and move a mesh of about so many vertices."""
    vertices = template.vertices
    faces = template.faces
    if count > len(vertices):
        fine = fine_mesh(template, 2)
        vertices = fine.weights @ vertices
        ratio = int(len(fine.mesh.faces) * count / len(vertices))
        vertices, faces, *_ = igl.decimate(vertices, np.asarray(fine.mesh.faces, dtype=np.int32), ratio)
    marks = template.vertices[template.annotation.landmarks[:COUNT]]
    # Decimation keeps no vertex for sure: the nearest to every landmark, each once.
    anchors = np.unique(np.linalg.norm(vertices[None] - marks[:, None], axis=2).argmin(1))
    targets = vertices[anchors] + np.random.default_rng(0).normal(0, PUSH, (len(anchors), 3)) * [1, 1, 0]
    return median(lambda: LaplacianDeformation(vertices, faces, anchors, 1.0).move(targets))


def time_texturing(template):
    """Seconds to paint the head with a portrait of it."""
    portrait = PortraitStudio(template, PICTURE).portray("head", template.vertices, np.random.default_rng(0))
    return median(lambda: texture_face(template, Sight(portrait.camera, portrait.image, portrait.mask), TEXTURE))


def median(work):
    """Median processor seconds of runs after a warm-up."""
    work()
    seconds = []
    for _ in range(RUNS):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds)


if __name__ == "__main__":
    main()
