from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.detect.find_faces import Candidate, common_share, find_faces, frames_overlap, without_doubles
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.calibration import Calibration
from caricli.models.detector.model import Detector, FaceCells
from caricli.structures.detection import FaceFrame


class Seer(Detector):
    """Says that there is a face where the window is bright, as large as the bright part."""

    def __init__(self):
        self.size = 128
        self.calibration = Calibration()

    def search(self, window):
        height, width = (length // 16 for length in window.shape[:2])
        means = window[..., 0].reshape(height, 16, width, 16).mean((1, 3))
        cell = np.indices((height, width)).reshape(2, -1).T
        y, x = (axis[window[..., 0] > 200] for axis in np.indices(window.shape[:2]))
        score = np.where(means == means.max(), 0.9, 0.0).ravel()
        centre = np.tile([x.mean(), y.mean()], (len(cell), 1))
        side = np.full(len(cell), x.max() - x.min() + 1.0)
        return FaceCells(score, centre, side, np.full(len(cell), 0.3), cell), np.zeros((height * 8, width * 8, 16))


@pytest.mark.parametrize("size", [(300, 200), (90, 120), (700, 700)])
def test_a_place_is_the_same_at_every_scale(size):
    picture = np.zeros((*size, 3), np.uint8)
    x, y, side = size[1] // 2, size[0] // 3, min(size) // 3
    picture[y : y + side, x : x + side] = 255
    settings = DetectSettings()
    candidates, glances = find_faces(picture, Seer(), settings.sides, settings)
    assert len(candidates) == 1 and len(glances) == 3
    middle = np.array([x, y]) + (side - 1) / 2
    np.testing.assert_allclose(candidates[0].frame.centre, middle, atol=0.02 * max(size))
    assert candidates[0].frame.side == pytest.approx(side, rel=0.25) and candidates[0].frame.roll == 0.3
    assert find_faces(picture, Seer(), settings.sides, replace(settings, most=0))[0] == []
    for glance in glances:
        # The middle of the picture is that of the window, to a part of a pixel.
        middles = [(np.array(shape[1::-1]) - 1) / 2 for shape in (picture.shape, 2 * np.array(glance.chances.shape))]
        np.testing.assert_allclose(glance.matrix[:, :2] @ middles[0] + glance.matrix[:, 2], middles[1])
        corner = glance.matrix[:, :2] @ np.array(size[::-1]) + glance.matrix[:, 2]
        assert (glance.matrix[:, 2] >= -1).all() and (corner <= 2 * np.array(glance.chances.shape[1::-1]) + 1).all()


def test_of_doubles_the_best_stays():
    frames = [FaceFrame(np.array([x, 50.0]), 40.0, 0.0) for x in (50, 55, 120)]
    assert frames_overlap(frames[0], frames[0]) == 1 and frames_overlap(frames[0], frames[2]) == 0
    assert frames_overlap(frames[0], frames[1]) == pytest.approx(35 / 45)
    assert common_share(frames[0], FaceFrame(np.array([50.0, 50.0]), 10.0, 0.0)) == 1
    candidates = [Candidate(frame, score) for frame, score in zip(frames, (0.5, 0.8, 0.3), strict=True)]
    assert without_doubles(candidates, 0.5) == [candidates[1], candidates[2]]
    assert without_doubles(candidates, 0.9) == [candidates[1], candidates[0], candidates[2]]
    within = Candidate(FaceFrame(np.array([52.0, 48.0]), 20.0, 0.0), 0.4)
    assert without_doubles([*candidates, within], 0.5) == [candidates[1], within, candidates[2]]
