"""What the spreads of found landmarks are worth to the fit: errors in space with them and without.

Usage: python benchmarks/spreads.py PICTURES PEOPLE [COUNT [HALF [DETECTOR]]]. PICTURES: a folder of `caricli dataset
pictures` of the dataset PEOPLE; its first COUNT (default: 40) pictures of one test person whose number is even (HALF
0) or odd (HALF 1, the default: `IntrinsicSettings.exact` was chosen on the others), of whose face at least 80 pixels
and two fifths of the landmarks are seen, and which the detector (default: the bundled one) finds to 15 % of its
diagonal.

Errors are mean distances on the face after the best similarity, millimetres; of differences the interval, too, when
people are drawn anew.
The last line is JSON.
"""

import json
import sys
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import read_dataset
from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.detect.see_face import see_face
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.pictures.sitter_shapes import sitter_shapes
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.store.detector import load_detector
from caricli.store.models import load_model, load_morphable

SMALLEST = 80
SEEN = 0.4
FARTHEST = 0.15


def found_landmarks(pictures, row, detector):
    """The Landmarks of the one face of a picture, or None where it is not measured."""
    truth = pictures.truth
    number = truth["picture"][row]
    true = truth["landmarks"][row]
    alone = len(pictures.faces(number)) == 1 and truth["visible"][row].mean() >= SEEN
    if not alone or np.ptp(true, axis=0).max() < SMALLEST:
        return None
    try:
        marks = see_face(pictures.picture(number), detector).landmarks
    except CaricliError:
        return None
    gaps = np.linalg.norm(marks.head_points - true, axis=1)[:68]
    return marks if np.nanmean(gaps) <= FARTHEST * np.linalg.norm(np.ptp(true[:68], axis=0)) else None


def error(vertices, true, region):
    """Millimetres."""
    scale, rotation, translation = similarity(vertices[region], true[region])
    return 1000 * np.linalg.norm(scale * vertices[region] @ rotation.T + translation - true[region], axis=1).mean()


def measured(pictures, people, half, detector):
    """Who a picture shows, and errors of both fits without spreads and with them, for each picture."""
    elastic = load_model()
    ways = (partial(fit_landmarks, model=elastic), partial(fit_morphable, model=load_morphable()))
    region = elastic.template.region("face")
    truth = pictures.truth
    sitters = sitter_shapes(pictures, people)
    for row in np.flatnonzero(np.isin(truth["picture"], pictures.pictures_of("test"))):
        who = truth["person"][row]
        marks = found_landmarks(pictures, row, detector) if who % 2 == half else None
        if marks is None:
            continue
        true = sitters.vertices[sitters.places[row]].astype(float)
        fits = [fit(marks.head_points, spreads=spreads) for fit in ways for spreads in (None, marks.spreads)]
        yield who, [error(fit.face.vertices, true, region) for fit in fits]


@threadpool_limits.wrap(limits=1)
def main():
    """Print means and the JSON line."""
    options = [*sys.argv[3:], *["40", "1", ""][len(sys.argv) - 3 :]]
    pictures = read_picture_set(Path(sys.argv[1]))
    detector = load_detector(Path(options[2]) if options[2] else None)
    rows = measured(pictures, read_dataset(Path(sys.argv[2])), int(options[1]), detector)
    people, errors = map(np.array, zip(*islice(rows, int(options[0])), strict=True))
    summary = {"pictures": len(errors), "detector": detector.model_id}
    for k, name in enumerate(("elastic", "morphable")):
        before, after = errors[:, 2 * k : 2 * k + 2].T
        change, low, high = ratio_interval(after - before, np.ones(len(errors)), people)
        summary[name] = {"without": before.mean(), "with": after.mean(), "change": change, "low": low, "high": high}
        interval = f"{change:+.2f}, {low:+.2f} to {high:+.2f}"
        print(f"{name:9} {before.mean():.2f} mm, with spreads {after.mean():.2f} mm ({interval})")
    print(json.dumps(summary))


if __name__ == "__main__":
    main()
