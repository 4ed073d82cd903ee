from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from caricli.methods.train.detector.fit_region_shift import fit_region_shift
from caricli.structures.detection import MarkedPicture
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape

SIZE = 128


def blots(generator, side):
    """(side, side) skin with blots of hair, without sharp corners."""
    noise = cv2.GaussianBlur(generator.normal(size=(side, side)), (0, 0), 6)
    return np.where(noise > 0, np.uint8(Region.HAIR), np.uint8(Region.SKIN))


@pytest.mark.parametrize("shift", [(0.4, -0.1), (0.0, 0.0), (-0.3, 0.35)])
def test_it_is_where_regions_are_shown(head_template, shift):
    """By a detector that sees the truth, which is the brightness of the picture, from aside."""
    generator = np.random.default_rng(0)
    pictures = []
    for size in generator.uniform(90, 130, 12):
        points = size * mean_shape(head_template) + [150, 150]
        regions = blots(generator, 300)
        pixels = np.repeat(16 * regions[..., None], 3, 2)
        pictures.append(MarkedPicture(pixels, regions, points[None], np.ones((1, len(points)), bool)))

    def parse(window):
        aside = np.array([[1.0, 0, -shift[0]], [0, 1, -shift[1]]])
        shown = cv2.warpAffine(window, aside, (SIZE, SIZE), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        dark, bright = 16.0 * Region.SKIN, 16.0 * Region.HAIR
        share = np.clip((shown[::2, ::2, 0] - dark) / (bright - dark), 0, 1)
        chances = np.zeros((SIZE // 2, SIZE // 2, len(Region)))
        chances[..., Region.HAIR] = share
        chances[..., Region.SKIN] = 1 - share
        return chances

    detector: Any = SimpleNamespace(size=SIZE, parse=parse)
    faces: Any = SimpleNamespace(faces=[(number, 0) for number in range(12)], marked=pictures.__getitem__)
    np.testing.assert_allclose(np.array(fit_region_shift(detector, faces, 12)), shift, atol=0.101)
