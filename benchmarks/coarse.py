"""What the coarse network tells of a face beyond its detected landmarks: 3D errors beside those of fits.

Usage: python benchmarks/coarse.py DATASET PICTURES [COUNT [NETWORK]]. The faces are COUNT (default: 100) of those of
PICTURES (of `dataset pictures DATASET`), of people whom neither network nor model was trained with, and the dataset is
none that the detector was trained on: drawn in all media, poses, lights and distances of that command; their landmarks
are read by the bundled detector from their true frames, as `detect` reads faces that it found. Compared are the mean
face of the morphable model, its fit to these landmarks and their spreads (`fit-morphable`), the network's word
(`fit-coarse --alone`), that word brought to the landmarks (`fit-coarse`), and two bounds: the fit to the true
landmarks, and the model's best. Errors are mean distances of the face's vertices after alignment in percent of the
head's height. The interval is that of the change of the mean, from 10,000 draws of the people with replacement. The
last line is JSON.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import read_dataset
from caricli.data.picture_set import read_picture_set
from caricli.data.unseen import unseen_data
from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.read_faces import look_at_face
from caricli.methods.detect.settings import DetectSettings
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.reconstruct.fit_coarse import fit_coarse
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.train.coarse.coarse_faces import TrueFaces
from caricli.store.coarse import load_coarse_pair
from caricli.store.detector import load_detector

DRAWS = 10_000
"""Of the people, for the interval."""


@threadpool_limits.wrap(limits=1)
def main(dataset, pictures, count=100, network=None):
    """Print means as they grow, the comparison and the JSON line."""
    teller, model = load_coarse_pair(None if network is None else Path(network))
    detector = load_detector()
    data = read_dataset(Path(dataset))
    unseen = unseen_data(data, {"network": teller.seen, "model": model.seen}, everyone=True)
    print(f"{unseen.test} of {unseen.of} people")
    drawn = read_picture_set(Path(pictures))
    drawn = replace(drawn, manifest=drawn.manifest | {"splits": unseen.data.manifest["splits"]})
    faces = TrueFaces(drawn, data, model, "test")
    chosen = np.random.default_rng(0).permutation(len(faces.faces))[: int(count)]
    errors = []
    people = []
    for done, number in enumerate(chosen, 1):
        errors.append(measure(faces.study(int(number)), model, teller, detector))
        picture, place = faces.faces[number]
        people.append(drawn.truth["person"][faces.rows[picture][place]])
        if done % 10 == 0 or done == len(chosen):
            print(done, ", ".join(f"{name} {np.mean([e[name] for e in errors]):.3f}" for name in errors[0]), flush=True)
    columns = {name: np.array([own[name] for own in errors]) for name in errors[0]}
    rows = {name: {"error": float(column.mean())} for name, column in columns.items()}
    for name in ("network", "network and landmarks"):
        rows[name] |= compare(columns["fit"], columns[name], np.array(people))
        print(name, "{change:.1f} % ({low:.1f} to {high:.1f}) of the fit's, lower on {lower}".format(**rows[name]))
    print(json.dumps({"faces": len(errors), "errors": rows}))


def measure(face, model, teller, detector):
    """Errors by name, and the NME of the detector's landmarks, of a StudiedFace."""
    image = face.picture.pixels
    true = face.picture.landmarks[0]
    read = look_at_face(image, face.frame, detector, DetectSettings())
    read = replace(read, points=space_jaw(read.points))
    shapes = {
        "mean face": model.mean,
        "fit": fit_morphable(read.points, model, spreads=read.spreads).face.vertices,
        "network": fit_coarse(read.points, model, teller, image, alone=True, spreads=read.spreads).face.vertices,
        "network and landmarks": fit_coarse(read.points, model, teller, image, spreads=read.spreads).face.vertices,
        "fit to true landmarks": fit_morphable(true, model).face.vertices,
        "the model's best": model.decode(model.encode(face.truth.vertices.astype(float))),
    }
    vertices = face.truth.vertices.astype(float)
    errors = {name: shape_error(shape, vertices, model.template) for name, shape in shapes.items()}
    gaps = np.linalg.norm(read.points - true, axis=1)[:68].mean()
    return errors | {"landmarks": float(100 * gaps / np.linalg.norm(np.ptp(true[:68], axis=0)))}


def compare(before, after, people):
    """How the mean error of people (N,) changes, in percent, with its interval, and on how many faces it is lower."""
    change, low, high = ratio_interval(100 * (after - before), before, people, DRAWS)
    return {"change": change, "low": low, "high": high, "lower": int((after < before).sum()), "of": len(before)}


if __name__ == "__main__":
    main(*sys.argv[1:])
