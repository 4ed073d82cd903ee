"""Landmarks to begin with, where no face was found in a picture."""

import numpy as np

from caricli.structures import Landmarks
from caricli.structures.detection import FaceFrame, turn_axes
from caricli.template.template import Template

_SHARE = 0.6
"""Of the shorter side of a picture: the face that is laid into its middle."""


def middle_frame(size: tuple[int, int]) -> FaceFrame:
    """An upright face in the middle of a picture of (width, height) pixels."""
    return FaceFrame((np.array(size, float) - 1) / 2, _SHARE * min(size), 0.0)


def lay_mean_shape(template: Template, frame: FaceFrame, size: tuple[int, int]) -> Landmarks:
    """The landmarks of a template's own face, seen from the front, in a frame of a picture.

    template: Template. frame: FaceFrame that the points of iBUG fill. size: (width, height) of the picture, pixels.
    Returns Landmarks, all of them known. Raises InputError where the frame is far outside the picture.
    """
    flat = template.vertices[template.annotation.landmarks][:, :2] * [1, -1]
    own = FaceFrame.of(flat)
    upright = (flat - own.centre) @ turn_axes(own.roll).T
    points = frame.centre + frame.side / own.side * upright @ turn_axes(frame.roll)
    return Landmarks(points, size)
