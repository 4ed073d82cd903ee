"""One frame of a rig (portrait paper, equation 13): milliseconds for 46 shapes at the paper's 35,709 vertices.

Usage: python benchmarks/rig_frames.py. The head's own expressions on the twice subdivided head, of which the first
35,709 vertices are taken, and as many shapes of noise, in which every vertex moves. Each row is the least of three
medians of runs after a warm-up, because other work on the machine only ever adds time. The alternatives say why it is
done as it is. The last line is JSON. The paper needs 3.56 ms.
"""

import json
import statistics
import time

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import saxpy

from caricli.methods.animate.pose_rig import RigPoser
from caricli.structures import Mesh, Rig
from caricli.template.fine_mesh import fine_mesh
from caricli.template.head import load_head

VERTICES, SHAPES = 35_709, 46
PAPER = 3.56
ROUNDS, RUNS = 3, 51


def milliseconds(work):
    """The least of the medians of some rounds of runs."""
    medians = []
    for _ in range(ROUNDS):
        work()
        seconds = []
        for _ in range(RUNS):
            start = time.perf_counter()
            work()
            seconds.append(time.perf_counter() - start)
        medians.append(1000 * statistics.median(seconds))
    return min(medians)


def rigs():
    """Yield names and rigs of 46 shapes."""
    head = load_head()
    template = head.template()
    fine = fine_mesh(template, 2)
    order = np.argsort(-np.abs(head.actions).max((1, 2)), kind="stable")[:SHAPES]
    deltas = np.stack([(fine.weights @ head.actions[k])[:VERTICES] for k in np.sort(order)]).astype(np.float32)
    neutral = (fine.weights @ template.vertices)[:VERTICES].astype(np.float32)
    noise = np.random.default_rng(0).normal(scale=0.01, size=deltas.shape).astype(np.float32)
    names = tuple(map(str, range(SHAPES)))
    # No triangle is looked at.
    faces = np.arange(VERTICES).reshape(-1, 3)
    for name, shapes in (("head's expressions", deltas), ("noise, all move", noise)):
        yield name, Rig(names, Mesh(neutral, faces), shapes)


def ways(rig):
    """Names and functions that pose a rig with all its shapes."""
    weights = np.random.default_rng(1).uniform(0.2, 1, SHAPES).astype(np.float32)
    poser, sparse = RigPoser(rig), sp.csr_matrix(rig.deltas.reshape(SHAPES, -1).T)
    rows, neutral, frame = rig.deltas.reshape(SHAPES, -1), rig.neutral.ravel(), np.empty(3 * VERTICES, np.float32)

    def one_by_one():
        frame[:] = neutral
        for row, weight in zip(rows, weights, strict=True):
            saxpy(row, frame, a=weight)

    half = weights * (np.arange(SHAPES) % 2)
    return {
        "RigPoser, 46 shapes": lambda: poser.pose(weights),
        "RigPoser, every other one": lambda: poser.pose(half),
        "one shape after the other": one_by_one,
        "sparse matrix": lambda: neutral + sparse @ weights,
        "numpy, double precision": lambda: rig.neutral + np.tensordot(weights.astype(float), rig.deltas, 1),
    }


def main():
    """Print the table and the JSON line."""
    rows = []
    print(f"{VERTICES} vertices, {SHAPES} shapes, milliseconds a frame; paper {PAPER}")
    for name, rig in rigs():
        share = float((np.abs(rig.deltas).max(2) > 1e-6).mean())
        for way, work in ways(rig).items():
            rows.append({"shapes": name, "moved": share, "way": way, "milliseconds": milliseconds(work)})
            print(f"{name:20} {100 * share:4.0f} % move  {way:28} {rows[-1]['milliseconds']:8.3f}")
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
