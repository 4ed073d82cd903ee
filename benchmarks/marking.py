"""How many detected points have to be moved by hand until a face fits: marking.py FOLDER.

FOLDER: pictures with landmarks of the same names (.txt), marked by hand. The detected point that is farthest from its
place is put there, again and again, as in the studio's mode Landmarks, each point alone or with the mirrored move on
the other side, until the points of the fitted face, where people would mark them, are less than 2 % of their diagonal
from the marks on average. The last line is JSON.
"""

import json
import sys
from pathlib import Path

import numpy as np

from caricli.io.image import read_image
from caricli.io.landmarks import read_landmarks
from caricli.methods.detect.see_face import see_face
from caricli.methods.marks.move_marks import move_point
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.detector import load_detector
from caricli.store.models import load_model
from caricli.structures.landmarks import COUNT

NEAR = 2.0
"""Percent of the diagonal."""

MOST = 44
"""Moves after which it is given up."""


def moves(marks, truth, model, symmetric_on):
    """NME of the fitted face at first, and how many points were moved, or None where it never came so near."""
    placed = np.zeros(COUNT, bool)
    first = None
    for done in range(MOST + 1):
        face = fit_landmarks(marks.head_points, model, spreads=marks.spreads).face
        gaps = np.linalg.norm(face.landmarks[:COUNT] - marks.slides[:COUNT] - truth.points, axis=1)
        error = float(100 * gaps.mean() / truth.diagonal)
        first = error if first is None else first
        if error < NEAR:
            return first, done
        away = np.linalg.norm(marks.points[:COUNT] - truth.points, axis=1)
        away[placed | ~np.isfinite(away)] = 0
        worst = int(np.argmax(away))
        marks = move_point(marks, worst, tuple(truth.points[worst]), symmetric_on)
        placed[worst] = True
    return first, None


if __name__ == "__main__":
    detector, model = load_detector(), load_model()
    rows = {}
    for file in sorted(Path(sys.argv[1]).glob("*.txt"), key=lambda path: (len(path.stem), path.stem)):
        truth = read_landmarks(file)
        seen = see_face(read_image(file.with_suffix(".jpg")), detector).landmarks
        first, alone = moves(seen, truth, model, None)
        _, both = moves(seen, truth, model, model.template)
        rows[file.stem] = {"first": first, "alone": alone, "both": both}
        print(file.stem, rows[file.stem], flush=True)
    print(json.dumps(rows))
