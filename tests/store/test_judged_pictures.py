from dataclasses import replace

import numpy as np
import pytest

from caricli.data.picture_set import read_picture_set
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.store.judged_pictures import JudgedPictures
from tests.drawn_pictures import mean_shape, write_drawn_set


def test_yaws_are_those_of_the_faces_of_each_picture(head_template, tmp_path):
    pictures = read_picture_set(write_drawn_set(tmp_path / "drawn", mean_shape(head_template), 3, seed=0))
    yaws = [10.0, -50.0, 70.0, 0.0]
    turns = np.stack([head_rotation(np.radians([0.3 * yaw, yaw, 0.0])) for yaw in yaws])
    told = replace(pictures, truth=pictures.truth | {"rotation": turns})
    found = [judged.yaws for judged in JudgedPictures(told, [2, 0])]
    fronts = turns[:, :, 2]
    expected = np.degrees(np.arctan2(fronts[:, 0], np.hypot(fronts[:, 1], fronts[:, 2])))
    assert np.concatenate(found) == pytest.approx(expected[[2, 3, 0]])
    assert np.abs(expected) == pytest.approx(np.abs(yaws))
