"""Rigs of caricatures: do lids and lips close, do triangles stay upright, how long does a transfer take.

Usage: python benchmarks/rigs.py DATASET [FACE.obj ...]. The faces are 50 meshes of a dataset at its highest level of
exaggeration, whoever they are, because nothing here was trained, and those that are named. Every figure stands beside
the one without contacts, as the paper does it. The last line is JSON.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import igl
import numpy as np

from caricli.data.dataset import read_dataset
from caricli.io.meshes.obj import read_obj
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.rig.add_eyeballs import fit_eyeballs
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.measure_rig import measure_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Mesh
from caricli.template.fine_mesh import fine_mesh
from caricli.template.head import load_head

FACES, RUNS = 50, 5
SIZES = 11_500, 35_709, 45_000
CLOSED, FLIPPED = 0.10, 0.002


def main():
    """Print the tables and the JSON line."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    data = read_dataset(Path(sys.argv[1]))
    head = load_head()
    templates = head_expressions(head, head.template())
    level = int(data.level.max())
    rows = spread_rows(data.level == level, FACES)
    sets = {f"{len(rows)} faces of level {level}": [data.vertices[row].astype(float) for row in rows]}
    if len(sys.argv) > 2:
        sets[f"{len(sys.argv) - 2} given faces"] = [read_obj(Path(name)).vertices for name in sys.argv[2:]]
    figures = {}
    for name, faces in sets.items():
        for contacts in (True, False):
            found = [measured(face, templates, contacts) for face in faces]
            figures[f"{name}, {'with' if contacts else 'without'} contacts"] = summary(found)
    for name, row in figures.items():
        print(name, *(f"  {key}: {value:.4g}" for key, value in row.items()), sep="\n")
    timings = {count: timed(templates, count) for count in SIZES}
    for count, seconds in timings.items():
        print(f"52 expressions on {count} vertices: {seconds:.2f} s (paper: 46 on 35,709 in 1.84 s)")
    print(json.dumps({"faces": figures, "seconds": timings}))


def measured(face, templates, contacts):
    """RigMeasures of a face."""
    deltas = transfer_rig(templates, face, contacts)
    eyeballs = fit_eyeballs(templates.mesh.with_vertices(face), templates.annotation, deltas)
    return measure_rig(face, deltas, templates, eyeballs)


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
        "both closed, share of faces": ((lids <= CLOSED) & (lips <= CLOSED)).mean(),
        "flipped triangles in the worst expression, mean %": 100 * flipped.mean(),
        "flipped triangles in the worst expression, worst %": 100 * flipped.max(),
        "faces within 0.2 %": (flipped <= FLIPPED).mean(),
        "lids inside eyeballs, worst mm": 1000 * max(each.inside for each in found),
    }


def timed(templates, count):
    """Median seconds of a transfer on a mesh of about so many vertices, made of the templates' by splitting edges."""
    levels = 1 if count < 17_000 else 2
    fine = fine_mesh(templates.mesh, levels)
    vertices = fine.weights @ templates.neutral
    # Every vertex that decimation leaves has one that it was born from, whose displacements it takes.
    ratio = int(len(fine.mesh.faces) * count / len(vertices))
    reduced, faces, _, kept = igl.decimate(vertices, np.asarray(fine.mesh.faces, dtype=np.int32), ratio)
    chosen = np.asarray(kept).ravel()
    deltas = np.stack([(fine.weights @ delta)[chosen] for delta in templates.deltas])
    own = ExpressionTemplates(templates.names, Mesh(reduced, np.asarray(faces)), deltas)
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
