"""Sketches of people of no training: how near the curves come to the lines, what turns over, and how long it takes.

Every mesh of the dataset that is taken is drawn from the front; the face that is likely for the lines is then moved
onto them. Distances are percent of the canvas; times are CPU milliseconds on one thread, for the head as it is and for
one whose triangles are cut in four, with curves of twice as many vertices.
"""

import argparse
import itertools
import json
import time
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import read_dataset
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.follow_lines import LineFollower
from caricli.methods.sketch.line_handles import LineHandles, lines_by_curve
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import Mesh
from caricli.template.feature_curves import FeatureCurve

FIGURES = ("before", "after", "worst", "flipped", "match", "solve", "fine_match", "fine_solve")


def timed(work):
    """What a call returns, and its milliseconds."""
    start = time.process_time()
    result = work()
    return result, 1000 * (time.process_time() - start)


def cut_in_four(mesh, curves):
    """The Mesh with a vertex in the middle of every edge, and curves along them."""
    edges, back = np.unique(
        np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_inverse=True
    )
    a, b, c = mesh.faces.T
    ab, bc, ca = len(mesh.vertices) + back.reshape(-1, 3).T
    faces = np.concatenate(
        [np.stack(corners, axis=1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    )
    middles = {tuple(edge): len(mesh.vertices) + row for row, edge in enumerate(edges.tolist())}
    finer = []
    for curve in curves:
        ids = curve.vertices[:1].tolist()
        for pair in itertools.pairwise(curve.vertices.tolist()):
            # Some steps of curves cross a triangle.
            ids += [*([middles[min(pair), max(pair)]] if (min(pair), max(pair)) in middles else []), pair[1]]
        old = np.flatnonzero(np.array(ids) < len(mesh.vertices))
        finer.append(FeatureCurve(curve.name, curve.kind, np.array(ids), old[curve.marks]))
    return Mesh(np.vstack([mesh.vertices, mesh.vertices[edges].mean(1)]), faces), tuple(finer)


class FinerHead:
    """Follows lines on a head whose triangles are cut in four."""

    def __init__(self, template, curves):
        """template: of the head. curves: FeatureCurves of it."""
        self.template = template
        rest, finer = cut_in_four(template, curves)
        self.handles = LineHandles(finer)
        self.follower = LineFollower(rest, self.handles)
        self.curves = curves

    def vertices(self, vertices):
        """(W, 3) of a face's vertices (V, 3)."""
        return cut_in_four(self.template.with_vertices(vertices), self.curves)[0].vertices


def times(follower, vertices, camera, lines):
    """Milliseconds of finding where on lines the handles go, and of moving a face's vertices (V, 3) there."""
    own = camera.project(vertices[follower.handles.vertices])
    places, match = timed(partial(follower.handles.places, lines, own))
    return match, timed(partial(follower.follow, vertices, camera, places))[1]


def main():
    """Follow sketches and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="a dataset whose people no model has seen")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--out", type=Path, required=True, help="JSON of the figures")
    options = parser.parse_args()
    model = load_model(kind=DEFAULT_LATENT)
    reconstruction = SketchReconstruction.of(elastic_encoder(model))
    handles = reconstruction.handles
    dataset = read_dataset(options.data)
    rows = np.linspace(0, len(dataset.vertices) - 1, options.count).astype(int)
    figures: dict[str, list[float]] = {key: [] for key in FIGURES}
    finer = FinerHead(model.template, handles.curves)
    with threadpool_limits(limits=1):
        for row in rows:
            vertices = np.asarray(dataset.vertices[row], float)
            sketch = draw_sketch(vertices, handles.curves, canvas_camera(vertices, handles.curves))
            fit = reconstruction.reconstruct(sketch)
            for key, value in (("before", fit.coarse["all"]), ("after", fit.errors["all"]), ("worst", fit.worst)):
                figures[key].append(value)
            figures["flipped"].append(fit.flipped)
            camera = fit.face.require_camera()
            lines = lines_by_curve(sketch)
            for name, follower, head in (
                ("", reconstruction.follower, fit.face.vertices),
                ("fine_", finer.follower, finer.vertices(fit.face.vertices)),
            ):
                match, solve = times(follower, head, camera, lines)
                figures[name + "match"].append(match)
                figures[name + "solve"].append(solve)
    report = {
        "sketches": len(rows),
        "vertices": len(model.template.vertices),
        "before": float(np.mean(figures["before"])),
        "after": float(np.mean(figures["after"])),
        "after_at_most": float(np.max(figures["after"])),
        "worst_point": float(np.max(figures["worst"])),
        "flipped": float(np.mean(figures["flipped"])),
        "flipped_at_most": float(np.max(figures["flipped"])),
    }
    times_of = {name + "_ms": float(np.median(figures[name])) for name in FIGURES[4:]}
    report |= times_of | {"fine_vertices": len(finer.follower.influence)}
    options.out.write_text(json.dumps(report, indent=1) + "\n")
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
