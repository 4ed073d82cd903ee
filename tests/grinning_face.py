"""A drawn grin that is labelled in part only, as a network labels what it has hardly ever seen."""

import cv2
import numpy as np

from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, LIPS, LIPS_INSIDE, Landmarks
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape

SKIN = (205, 150, 120)
TEETH = (245, 243, 235)


class GrinningFace:
    """A face of 300 pixels, its eyes wide and its teeth bare.

    image: (400, 400, 3) uint8. regions: (400, 400), teeth taken for skin, of eyes a part. mouth, eyes: (400, 400) bool,
    what is seen of them. truth: (81, 2) landmarks. marks: Landmarks whose mouth is shut, unsure.
    """

    def __init__(self, template, wide=1.6):
        """wide: how many times as large eyes are as landmarks have them."""
        closed = 240 * mean_shape(template) + [200, 180]
        self.truth = closed.copy()
        middle = closed[list(LIPS_INSIDE)].mean(0)
        self.truth[list(LIPS)] = middle + (closed[list(LIPS)] - middle) * [1.2, 2.2]
        self.truth[list(LIPS_INSIDE)] = self.truth[[48, 50, 51, 52, 54, 56, 57, 58]] * 0.75 + 0.25 * middle
        for eye in (EYE_RIGHT, EYE_LEFT):
            own = closed[list(eye)].mean(0)
            self.truth[list(eye)] = own + wide * (closed[list(eye)] - own)
        paper = np.random.default_rng(0).normal(0, 4, (400, 400, 3))
        self.image = np.clip(SKIN + paper, 0, 255).astype(np.uint8)
        self.mouth = self._enclosed(self.truth[list(LIPS_INSIDE)])
        self.eyes = self._enclosed(self.truth[list(EYE_RIGHT)]) | self._enclosed(self.truth[list(EYE_LEFT)])
        lips = self._enclosed(self.truth[list(LIPS)]) & ~self.mouth
        self.image[lips] = (170, 60, 70)
        self.image[self.mouth] = TEETH
        self.image[self.eyes] = (235, 240, 250)
        seen = self._enclosed(closed[list(EYE_RIGHT)]) | self._enclosed(closed[list(EYE_LEFT)])
        self.regions = np.full((400, 400), Region.SKIN, np.uint8)
        self.regions[lips] = Region.LIPS
        self.regions[seen] = Region.EYES
        spreads = np.tile(400 * np.eye(2), (81, 1, 1))
        self.marks = Landmarks(closed, (400, 400), spreads)

    def _enclosed(self, points):
        mask = np.zeros((400, 400), np.uint8)
        cv2.fillPoly(mask, [np.rint(points).astype(np.int32)], 1)
        return mask > 0
