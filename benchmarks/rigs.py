"""Rigs of caricatures: do lids and lips close, do triangles stay upright, how long does a transfer take.

Usage: python benchmarks/rigs.py DATASET [FACE.obj ...]. The faces are 50 test meshes of a dataset at its highest level
of exaggeration, and those that are named. Every figure stands beside the one without contacts, as the paper does it.
The last line is JSON.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import igl
import numpy as np

from caricli.data.dataset import read_dataset
from caricli.geometry.similarity import similarity
from caricli.io.obj import read_obj
from caricli.methods.rig.add_eyeballs import fit_eyeballs
from caricli.methods.rig.expression_templates import ExpressionTemplates, mended_templates
from caricli.methods.rig.measure_rig import measure_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.template.fine_mesh import fine_mesh
from caricli.template.head import load_head

FACES, RUNS = 50, 5
SIZES = 11_500, 35_709, 45_000
CLOSED, FLIPPED = 0.10, 0.002


def main():
    """Print the tables and the JSON line."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    data, head = read_dataset(Path(sys.argv[1])), load_head()
    template = head.template()
    templates = mended_templates(head, template)
    level = int(data.level.max())
    rows = np.flatnonzero(data.rows("test") & (data.level == level))[:FACES]
    sets = {f"{len(rows)} test faces of level {level}": [data.vertices[row].astype(float) for row in rows]}
    if len(sys.argv) > 2:
        sets[f"{len(sys.argv) - 2} given faces"] = [read_obj(Path(name)).vertices for name in sys.argv[2:]]
    figures = {}
    for name, faces in sets.items():
        for contacts in (True, False):
            found = [measured(face, templates, template, contacts) for face in faces]
            figures[f"{name}, {'with' if contacts else 'without'} contacts"] = summary(found)
    for name, row in figures.items():
        print(name, *(f"  {key}: {value:.4g}" for key, value in row.items()), sep="\n")
    timings = {count: timed(templates, template, count) for count in SIZES}
    for count, seconds in timings.items():
        print(f"52 expressions on {count} vertices: {seconds:.2f} s (paper: 46 on 35,709 in 1.84 s)")
    print(json.dumps({"faces": figures, "seconds": timings}))


def measured(face, templates, template, contacts):
    """RigMeasures of a face."""
    deltas = transfer_rig(templates, face, contacts)
    mesh = template.with_vertices(face)
    balls = fit_eyeballs(face, deltas, mesh)
    scale = similarity(templates.neutral, face)[0]
    return measure_rig(deltas, face, templates, template.annotation, scale, balls)


def summary(found):
    """Means, worst cases and shares of faces that hold."""
    lids = np.array([max(each.lid_gap.values()) for each in found])
    lips = np.array([each.lip_gap for each in found])
    flipped = np.array([each.flipped.max() for each in found])
    return {
        "lid gap, mean": lids.mean(),
        "lid gap, worst": lids.max(),
        "lids closed, share of faces": (lids <= CLOSED).mean(),
        "lip gap, mean": lips.mean(),
        "lip gap, worst": lips.max(),
        "lips closed, share of faces": (lips <= CLOSED).mean(),
        "flipped triangles in the worst expression, mean %": 100 * flipped.mean(),
        "flipped triangles in the worst expression, worst %": 100 * flipped.max(),
        "faces within 0.2 %": (flipped <= FLIPPED).mean(),
        "lids inside eyeballs, worst mm": 1000 * max(each.inside for each in found),
    }


def timed(templates, template, count):
    """Median seconds of a transfer on a mesh of about so many vertices, made of the template's by splitting edges."""
    levels = 1 if count < 17_000 else 2
    fine = fine_mesh(template, levels)
    vertices = fine.weights @ templates.neutral
    # Every vertex that decimation leaves has one that it was born from, whose displacements it takes.
    ratio = int(len(fine.mesh.faces) * count / len(vertices))
    reduced, faces, _, kept = igl.decimate(vertices, np.asarray(fine.mesh.faces, dtype=np.int32), ratio)
    chosen = np.asarray(kept).ravel()
    deltas = np.stack([(fine.weights @ delta)[chosen] for delta in templates.deltas])
    own = ExpressionTemplates(templates.names, reduced, np.asarray(faces), deltas)
    face = 1.1 * own.neutral * [1.1, 0.9, 1.2]
    transfer_rig(own, face)
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        transfer_rig(own, face)
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


if __name__ == "__main__":
    main()
