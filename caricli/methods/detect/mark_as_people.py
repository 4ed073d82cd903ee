"""Detected landmarks where people mark them."""

from dataclasses import replace

import numpy as np

from caricli.geometry.lines.mark_lines import mark_lines
from caricli.models.detector.jaw_places import JawPlaces
from caricli.structures.landmarks import COUNT, Landmarks


def mark_as_people(seen: Landmarks, jaw: JawPlaces) -> Landmarks:
    """Landmarks whose points are where people mark them, and that know where those of the head were seen.

    What is seen are the head's own landmarks, which its annotation has elsewhere along brows, nose, lips and jaw than
    people have them in photographs and drawings. seen: Landmarks of a detector, the jaw's at equal distances.
    """
    whole = seen.known[:COUNT].all()
    points = mark_lines(jaw.mark(seen.points) if whole else seen.points)
    return replace(seen, points=points, slides=np.nan_to_num(seen.points - points))
