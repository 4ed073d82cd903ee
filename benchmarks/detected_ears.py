"""Ears of faces that were detected, with truth: as the detector saw them, and where the picture is searched besides.

Usage: python benchmarks/detected_ears.py PICTURES [COUNT [SPLIT]]. Of PICTURES (of `dataset pictures`) those of people
of SPLIT (default: everybody, as in the test set; test, of pictures that the detector was trained with) that show one
face of at least 80 pixels, until COUNT (default: 60) of them were found; landmarks and spreads are those of `detect`.
Two elastic fits are compared, as `reconstruct-from-landmarks` makes them: to the landmarks alone, and where ears that
stand out in the picture count beside detected ones (`Outline.joined`, whose constants were chosen on validation
people). Errors are mean distances of an ear's three landmarks from the truth, in the picture, in percent of the
diagonal of the 68, of ears of which two can be seen. The interval is that of the change of the mean, from 10,000 draws
of the people with replacement. Seconds are medians of processor time for one fit. The last line is JSON.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.dataset import SPLITS
from caricli.data.picture_set import read_picture_set
from caricli.errors import CaricliError
from caricli.methods.detect.see_face import see_face
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT, EAR_LEFT, EAR_RIGHT

SMALLEST = 80
"""Pixels, of the longer side of the box of the 68."""

MISTAKEN = 0.1
"""Of the diagonal: landmarks that are farther off on average are those of something else."""

DRAWS = 10_000
EARS = ([*EAR_RIGHT], [*EAR_LEFT])


def faces(folder, split):
    """Pictures with their landmarks (81, 2), which of these can be seen, and the number of who it is."""
    pictures = read_picture_set(folder)
    splits = SPLITS if split is None else [split]
    for number in sorted(number for name in splits for number in pictures.pictures_of(name)):
        rows = pictures.faces(int(number))
        if len(rows) == 1:
            points = pictures.truth["landmarks"][rows[0]]
            if np.ptp(points[:COUNT], axis=0).max() >= SMALLEST:
                visible, person = (pictures.truth[name][rows[0]] for name in ("visible", "person"))
                yield pictures.picture(int(number)), points, visible, person


def measure(image, points, visible, seen, model):
    """For each ear of a face that can be seen: errors alone and with the picture, and whether one was found."""
    diagonal = np.linalg.norm(np.ptp(points[:COUNT], axis=0))
    marks = seen.landmarks
    places = []
    seconds = []
    for picture in (None, ParsedPicture(image, seen.regions)):
        start = time.process_time()
        fit = fit_landmarks(marks.head_points, model, picture=picture, spreads=marks.spreads)
        seconds.append(time.process_time() - start)
        places.append(fit.face.landmarks)
    rows = []
    for ear in EARS:
        own = [number for number in ear if visible[number]]
        if len(own) > 1:
            errors = [100 * np.linalg.norm(p[own] - points[own], axis=1).mean() / diagonal for p in places]
            stands_out = fit.outline is not None and fit.outline.confidence[np.array(ear) - COUNT].all()
            rows.append((*errors, stands_out))
    return rows, seconds


def change(measured, people):
    """Of the mean error, by which share it changes, with its interval."""
    before, after = (np.array([sum(row[k] for row in rows) for rows in measured]) for k in (0, 1))
    share, *interval = ratio_interval(after - before, before, np.array(people), DRAWS)
    return share, interval


@threadpool_limits.wrap(limits=1)
def main(folder, count=60, split=None):
    """Print the comparison and the JSON line."""
    detector = load_detector()
    model = load_model(kind="intrinsic")
    model.prepare()
    measured = []
    people = []
    seconds = []
    for image, points, visible, person in faces(Path(folder), split):
        try:
            seen = see_face(image, detector)
        except CaricliError:
            continue
        off = np.nanmean(np.linalg.norm(seen.landmarks.head_points - points, axis=1)[:COUNT])
        if off > MISTAKEN * np.linalg.norm(np.ptp(points[:COUNT], axis=0)):
            continue
        rows, own = measure(image, points, visible, seen, model)
        seconds.append(own)
        if rows:
            measured.append(rows)
            people.append(person)
        if len(seconds) == int(count):
            break
    ears = np.array([row for rows in measured for row in rows])
    standing = ears[ears[:, 2] > 0, :2]
    share, interval = change(measured, people)
    figures = {
        "all": {
            "ears": len(ears), "alone": ears[:, 0].mean(), "picture": ears[:, 1].mean(),
            "better": int((ears[:, 1] < ears[:, 0]).sum()),
            "change": 100 * share, "low": 100 * interval[0], "high": 100 * interval[1],
        },
        "that stand out": {
            "ears": len(standing), "alone": standing[:, 0].mean(), "picture": standing[:, 1].mean(),
            "better": int((standing[:, 1] < standing[:, 0]).sum()),
        },
    }  # fmt: skip
    taken = [statistics.median(column) for column in zip(*seconds, strict=True)]
    print(f"{len(seconds)} faces, a fit takes {taken[0]:.2f} and {taken[1]:.2f} s")
    print(json.dumps({"ears": figures}))


if __name__ == "__main__":
    main(*sys.argv[1:])
