"""Teeth of open mouths, with truth: where a usual head has them, and as far as the picture shows them.

Usage: python -m benchmarks.pictured_teeth PICTURES [COUNT]. Of PICTURES (of `dataset pictures`) those that show one
face of at least 80 pixels, until COUNT (default: 60) faces whose open mouths tell of their teeth were detected and
fitted, as `portrait` begins. Pixels of teeth that a fitted head shows its camera are compared with those of the
picture's true regions, without what the picture says of teeth (`shown_teeth`) and with it: mean intersection over
union, and the interval of its change from 10,000 draws of the people with replacement. The last line is JSON.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.detected_ears import DRAWS, SMALLEST
from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.methods.detect.see_face import see_face
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.parts.whole_head import whole_face
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.texture.shown_teeth import shown_teeth
from caricli.render.visibility.rasterise import rasterise
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures import HeadChoice, Material
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region

MOUTH = HeadChoice(("skin", "teeth", "tongue"))


def overlaps(image, truth, detector, model):
    """Intersection over union without and with what a picture says of teeth, None where it says nothing.

    truth: (H, W) values of Region.
    """
    seen = see_face(image, detector)
    marks = seen.landmarks
    face = fit_landmarks(
        marks.head_points, model, picture=ParsedPicture(image, seen.regions), spreads=marks.spreads
    ).face
    teeth = shown_teeth(face, model.template.with_vertices(face.vertices), seen.regions)
    if teeth is None or not np.isin(truth, (Region.MOUTH, Region.TEETH)).any():
        return None
    values = []
    for head in (face, replace(face, teeth=teeth)):
        whole = whole_face(head, MOUTH)
        raster = rasterise(face.camera.place(whole.vertices), whole.faces, *image.shape[1::-1])
        shown = (raster.face >= 0) & (whole.triangle_materials[raster.face] == Material.TEETH)
        expected = truth == Region.TEETH
        values.append((shown & expected).sum() / max((shown | expected).sum(), 1))
    return values


@threadpool_limits.wrap(limits=1)
def main(folder, count=60):
    """Print the comparison as JSON."""
    pictures = read_picture_set(Path(folder))
    detector = load_detector()
    model = load_model(kind="intrinsic")
    rows = []
    people = []
    for number in range(pictures.count):
        faces = pictures.faces(number)
        if len(faces) != 1 or np.ptp(pictures.truth["landmarks"][faces[0]][:COUNT], axis=0).max() < SMALLEST:
            continue
        try:
            row = overlaps(pictures.picture(number), pictures.regions(number), detector, model)
        except CaricliError:
            continue
        if row is not None:
            rows.append(row)
            people.append(pictures.truth["person"][faces[0]])
        if len(rows) == int(count):
            break
    usual, pictured = np.array(rows).T
    change, *interval = ratio_interval(pictured - usual, np.ones(len(rows)), np.array(people), DRAWS)
    figures = {"faces": len(rows), "usual": usual.mean(), "pictured": pictured.mean()}
    figures |= {"better": int((pictured > usual).sum()), "change": change, "low": interval[0], "high": interval[1]}
    print(json.dumps({"pictured_teeth": figures}))


if __name__ == "__main__":
    main(*sys.argv[1:])
