"""Ears, necks and sides of faces that were detected, with truth: as landmarks tell them, and as the picture shows them.

Usage: python -m benchmarks.pictured_outlines DATASET PICTURES [COUNT]. Of PICTURES (of `dataset pictures DATASET`)
those that show one face of at least 80 pixels, until COUNT (default: 300) faces were detected and fitted, as `portrait`
begins. Ears: intersection over union of the true label and the ears that the fitted head shows, where nothing hides
them, without and with `fit_ears`, and the interval of its change from 10,000 draws of the people with replacement; of
faces whose ears it moved. Necks: of the width of the neck's edge to that of the true head's, brought to it by a
similarity of the face, the median of how far it is from 1, percent, without and with `fit_neck`, and how many became
thinner, and by more than a fifth: no person of a dataset has a thin neck. Sides, after both: of faces whose sides came
in (`fit_sides`), how much of the head is before true background, percent, and how far the skin without ears is from the
truth, brought to it by a similarity, percent of the head's height, without and with it. The last line is JSON.
"""

import json
import sys
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.detected_ears import DRAWS, MISTAKEN, SMALLEST
from caricli.data.dataset import read_dataset
from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.detect.see_face import see_face
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.pictures.sitter_shapes import sitter_shapes
from caricli.methods.reconstruct.fit_ears import EARS, fit_ears
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_neck import fit_neck
from caricli.methods.reconstruct.fit_sides import fit_sides
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.render.visibility.rasterise import rasterise
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region
from caricli.template.annotation import CAVITIES

BEHIND = (Region.EARS, Region.BACKGROUND, Region.SKIN, Region.NECK, Region.CLOTH)
"""What is labelled where an ear would be seen."""


def fitted_face(image, points, detector, model):
    """A face as landmarks and the search for ears tell it, and its ParsedPicture; None where another was found."""
    seen = see_face(image, detector)
    marks = seen.landmarks
    off = np.nanmean(np.linalg.norm(marks.head_points - points, axis=1)[:COUNT])
    if off > MISTAKEN * np.linalg.norm(np.ptp(points[:COUNT], axis=0)):
        return None
    found = fit_landmarks(marks.head_points, model, picture=ParsedPicture(image), spreads=marks.spreads).face
    return found, ParsedPicture(image, seen.regions)


def ear_overlap(face, template, regions):
    """Of the ears that a face shows and those of true regions (H, W)."""
    raster = rasterise(face.camera.place(face.vertices), face.faces, *regions.shape[::-1])
    ears = template.mask(*EARS)[face.faces].all(1)
    shown = (raster.face >= 0) & ears[raster.face] & np.isin(regions, BEHIND)
    true = regions == Region.EARS
    return (shown & true).sum() / max((shown | true).sum(), 1)


def neck_width(face, template, truth):
    """Of the neck's edge to that of the true head (V, 3)."""
    region, edge = template.region("face"), template.neck.edge
    scale, *_ = similarity(face.vertices[region], truth[region])
    return scale * np.ptp(face.vertices[edge, 0]) / np.ptp(truth[edge, 0])


def side_figures(face, template, truth, regions):
    """Of a face, its share before background of true regions (H, W), percent, and its distance from truth (V, 3)."""
    shown = covered_pixels(face.camera.place(face.vertices), face.faces, *regions.shape[::-1])
    skin = ~template.mask(*CAVITIES, *EARS)
    scale, rotation, translation = similarity(face.vertices[skin], truth[skin])
    places = scale * face.vertices[skin] @ rotation.T + translation
    away = np.linalg.norm(places - truth[skin], axis=1).mean() / np.ptp(truth[:, 1])
    return 100 * (shown & (regions == Region.BACKGROUND)).sum() / shown.sum(), 100 * away


@threadpool_limits.wrap(limits=1)
def main(dataset, pictures, count=300):
    """Print the comparison as JSON."""
    drawn = read_picture_set(Path(pictures))
    sitters = sitter_shapes(drawn, read_dataset(Path(dataset)))
    detector = load_detector()
    model = load_model(kind="intrinsic")
    ears, necks, sides, people = [], [], [], []
    for number in range(drawn.count):
        rows = drawn.faces(number)
        points = drawn.truth["landmarks"][rows[:1]]
        if len(rows) != 1 or np.ptp(points[0, :COUNT], axis=0).max() < SMALLEST:
            continue
        try:
            fitted = fitted_face(drawn.picture(number), points[0], detector, model)
        except CaricliError:
            continue
        if fitted is None:
            continue
        face, picture = fitted
        truth = sitters.vertices[sitters.places[rows[0]]].astype(float)
        thin, _ = fit_neck(face, model.template, picture)
        necks.append([neck_width(each, model.template, truth) for each in (face, thin)])
        outlined = fit_ears(face, model.template, picture)
        if outlined is not face:
            ears.append([ear_overlap(each, model.template, drawn.regions(number)) for each in (face, outlined)])
            people.append(drawn.truth["person"][rows[0]])
        usual, _ = fit_neck(outlined, model.template, picture)
        come_in = fit_sides(usual, model.template, picture, model.template.annotation.landmarks)
        if come_in is not usual:
            regions = drawn.regions(number)
            sides.append([side_figures(each, model.template, truth, regions) for each in (usual, come_in)])
        if len(necks) == int(count):
            break
    before, after = np.array(ears).T
    change, *interval = ratio_interval(after - before, np.ones(len(ears)), np.array(people), DRAWS)
    usual, pictured = np.array(necks).T
    (wide, far), (narrow, near) = np.mean(sides, axis=0)
    figures = {
        "ear_outlines": {
            "faces": len(ears), "usual": before.mean(), "pictured": after.mean(),
            "better": int((after > before).sum()), "change": change, "low": interval[0], "high": interval[1],
        },
        "neck_widths": {
            "faces": len(necks), "usual": 100 * float(np.median(np.abs(np.log(usual)))),
            "pictured": 100 * float(np.median(np.abs(np.log(pictured)))),
            "thinner": int((pictured < usual).sum()), "mistaken": int((pictured < 0.8 * usual).sum()),
        },
        "sides": {"faces": len(sides), "wide": wide, "narrow": narrow, "far": far, "near": near},
    }  # fmt: skip
    print(json.dumps(figures))


if __name__ == "__main__":
    main(*sys.argv[1:])
