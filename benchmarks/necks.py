"""Necks of faces that were detected, with truth: usual ones must not be taken for thin.

Usage: python -m benchmarks.necks DATASET PICTURES [COUNT]. Of PICTURES (of `dataset pictures DATASET`) those
that show one face of at least 80 pixels, until COUNT (default: 300) faces were detected and fitted, as `portrait`
begins. Compared are widths of the necks' edges with those of the true heads, brought to them by a similarity of the
face: the median of how far the ratio is from 1 without what the picture says of necks (`fit_neck`) and with it, and how
many necks became thinner. No person of the dataset has a thin neck. The last line is JSON.
"""

import json
import sys
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.detected_ears import MISTAKEN, SMALLEST
from caricli.data.dataset import read_dataset
from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.geometry.similarity import similarity
from caricli.methods.detect.see_face import see_face
from caricli.methods.pictures.sitter_shapes import sitter_shapes
from caricli.methods.reconstruct.find_neck import fit_neck
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT


def ratios(image, points, truth, detector, model):
    """Widths of a neck's edge to the true one's (V, 3), without and with what the picture says of it."""
    template = model.template
    seen = see_face(image, detector)
    marks = seen.landmarks
    off = np.nanmean(np.linalg.norm(marks.head_points - points, axis=1)[:COUNT])
    if off > MISTAKEN * np.linalg.norm(np.ptp(points[:COUNT], axis=0)):
        return None
    face = fit_landmarks(marks.head_points, model, spreads=marks.spreads).face
    heads = (face, fit_neck(face, template, ParsedPicture(image, seen.regions))[0])
    region = template.region("face")
    scale, *_ = similarity(face.vertices[region], truth[region])
    edge = template.neck.edge
    return [scale * np.ptp(head.vertices[edge, 0]) / np.ptp(truth[edge, 0]) for head in heads]


@threadpool_limits.wrap(limits=1)
def main(dataset, pictures, count=300):
    """Print the comparison and the JSON line."""
    drawn = read_picture_set(Path(pictures))
    sitters = sitter_shapes(drawn, read_dataset(Path(dataset)))
    detector = load_detector()
    model = load_model(kind="intrinsic")
    rows = []
    for number in range(drawn.count):
        own = drawn.faces(number)
        if len(own) != 1 or np.ptp(drawn.truth["landmarks"][own[0]][:COUNT], axis=0).max() < SMALLEST:
            continue
        points = drawn.truth["landmarks"][own[0]]
        try:
            row = ratios(
                drawn.picture(number), points, sitters.vertices[sitters.places[own[0]]].astype(float), detector, model
            )
        except CaricliError:
            continue
        rows += [] if row is None else [row]
        if len(rows) == int(count):
            break
    usual, pictured = np.array(rows).T
    figures = {
        "faces": len(rows),
        "usual": float(np.median(np.abs(np.log(usual)))),
        "pictured": float(np.median(np.abs(np.log(pictured)))),
        "thinner": int((pictured < usual).sum()),
    }
    print("widths of those that became thinner, of what they were:", np.sort((pictured / usual)[pictured < usual]))
    print(json.dumps({"necks": figures}))


if __name__ == "__main__":
    main(*sys.argv[1:])
