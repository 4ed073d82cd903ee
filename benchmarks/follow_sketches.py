"""Sketches of people of no training: how near the curves come to the lines, what turns over, and how long it takes.

Every mesh of the dataset that is taken is drawn from the front; the face that is likely for the lines is then moved
onto them. Distances are percent of the canvas; times are CPU milliseconds on one thread.
"""

import argparse
import json
import time
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import read_dataset
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.methods.sketch.model_coarse import model_coarse
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.models import DEFAULT_LATENT, load_model


def timed(work):
    """What a call returns, and its milliseconds."""
    start = time.process_time()
    result = work()
    return result, 1000 * (time.process_time() - start)


def main():
    """Follow sketches and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="a dataset whose people no model has seen")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--out", type=Path, required=True, help="JSON of the figures")
    options = parser.parse_args()
    model = load_model(kind=DEFAULT_LATENT)
    reconstruction = SketchReconstruction(model, partial(model_coarse, encoder=elastic_encoder(model)))
    handles = reconstruction.handles
    dataset = read_dataset(options.data)
    rows = np.linspace(0, len(dataset.vertices) - 1, options.count).astype(int)
    figures: dict[str, list[float]] = {key: [] for key in ("before", "after", "worst", "flipped", "match", "solve")}
    with threadpool_limits(limits=1):
        for row in rows:
            vertices = np.asarray(dataset.vertices[row], float)
            sketch = draw_sketch(vertices, handles.curves, canvas_camera(vertices, handles.curves))
            fit = reconstruction.reconstruct(sketch)
            for key, value in (("before", fit.coarse["all"]), ("after", fit.errors["all"]), ("worst", fit.worst)):
                figures[key].append(value)
            figures["flipped"].append(fit.flipped)
            camera = fit.face.require_camera()
            own = camera.project(fit.face.vertices[handles.vertices])
            lines = lines_by_curve(sketch)
            places, milliseconds = timed(partial(handles.places, lines, own))
            figures["match"].append(milliseconds)
            follow = partial(reconstruction.follower.follow, fit.face.vertices, camera, places)
            figures["solve"].append(timed(follow)[1])
    report = {
        "sketches": len(rows),
        "vertices": len(model.template.vertices),
        "before": float(np.mean(figures["before"])),
        "after": float(np.mean(figures["after"])),
        "after_at_most": float(np.max(figures["after"])),
        "worst_point": float(np.max(figures["worst"])),
        "flipped": float(np.mean(figures["flipped"])),
        "flipped_at_most": float(np.max(figures["flipped"])),
        "match_ms": float(np.median(figures["match"])),
        "solve_ms": float(np.median(figures["solve"])),
    }
    options.out.write_text(json.dumps(report, indent=1) + "\n")
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
