"""Refining by the Laplacian of the portrait paper, as published and as it is here, with truth.

Usage: python benchmarks/laplacian.py DATASET [COUNT]. COUNT (default: 60) meshes of people whom the morphable model was
not trained with are seen in random poses; their 68 landmarks are 0.3 % of their diagonal off (standard deviation of a
coordinate). The morphable model is fitted to them (`fit-morphable`), then refined. Landmark errors are in percent of
the diagonal, 3D errors mean distances of the face's vertices after alignment in percent of the head's height, flipped
triangles in percent. The last line is JSON.
"""

import json
import sys
from pathlib import Path

import numpy as np

from caricli.data.dataset import read_dataset
from caricli.data.unseen import unseen_data
from caricli.methods.evaluate.evaluate_blendshapes import random_camera
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.refine_face import refine_face
from caricli.methods.reconstruct.settings import RefineSettings
from caricli.store.models import load_morphable
from caricli.structures.landmarks import COUNT

FACES = 60
NOISE = 0.003
RIVALS = {
    "uniform, no rotations (published)": RefineSettings(laplacian="uniform", rounds=0),
    "uniform, rotations": RefineSettings(laplacian="uniform"),
    "cotangent, no rotations": RefineSettings(rounds=0),
    "cotangent, rotations (`refine`)": RefineSettings(),
}


def main():
    """Print the means and the JSON line."""
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__)
    model = load_morphable()
    data = unseen_data(read_dataset(Path(sys.argv[1])), {"morphable": model.seen}, everyone=True).data
    generator = np.random.default_rng(0)
    measured = {name: [] for name in ("before", *RIVALS)}
    for row in spread_rows(data.rows("test"), int(sys.argv[2]) if len(sys.argv) > 2 else FACES):
        truth = data.vertices[row].astype(float)
        camera = random_camera(generator, np.ptp(truth[:, 1]))
        points = camera.project(truth[landmark_vertices(truth, camera.rotation, data.template, COUNT)])
        points += generator.normal(0, NOISE * np.linalg.norm(np.ptp(points, axis=0)), points.shape)
        face = fit_morphable(points, model).face
        for name, settings in RIVALS.items():
            refined = refine_face(face, points, data.template, settings)
            error = shape_error(refined.face.vertices, truth, data.template)
            measured[name].append((refined.after["all"], error, 100 * refined.flipped))
        measured["before"].append((refined.before["all"], shape_error(face.vertices, truth, data.template), np.nan))
    means = {name: np.mean(figures, axis=0).tolist() for name, figures in measured.items()}
    rows = [
        {"name": name, "nme": nme, "error": error, "flipped": flipped} for name, (nme, error, flipped) in means.items()
    ]
    for each in rows:
        print(f"{each['name']:36} {each['nme']:6.2f} {each['error']:6.3f} {each['flipped']:6.3f}")
    del rows[0]["flipped"]
    print(json.dumps({"rows": rows, "faces": len(measured["before"])}))


if __name__ == "__main__":
    main()
