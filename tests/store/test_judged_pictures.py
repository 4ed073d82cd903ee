from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.data.picture_set import read_picture_set
from caricli.errors import InputError
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.store.judged_pictures import JudgedPictures, load_judged_sets
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


def test_whom_a_detector_has_seen_does_not_judge_it(head_template, tmp_path):
    marks = {"train": "aaaaaaaaaaaa bbbbbbbbbbbb", "validation": "cccccccccccc", "test": "dddddddddddd"}
    folder = write_drawn_set(tmp_path / "drawn", mean_shape(head_template), 16, 0, people=marks)

    def judged(**people):
        detector: Any = SimpleNamespace(recipe={"people": {"train": "", "validation": ""} | people})
        sets, note = load_judged_sets(folder, None, detector, 16, 1)
        return len(sets["generated"]), note

    assert judged(train="eeeeeeeeeeee") == (16, None)
    fewer = [judged(train="eeeeeeeeeeee bbbbbbbbbbbb"), judged(validation="cccccccccccc")]
    assert fewer[0] == fewer[1] and 0 < fewer[0][0] < 8 and "has seen some of its people" in fewer[0][1]
    for use in ("train", "validation"):
        with pytest.raises(InputError, match="drawn: expected test people whom the detector was not trained with"):
            judged(**{use: "dddddddddddd"})
    unknown: Any = SimpleNamespace(recipe=None)
    sets, note = load_judged_sets(folder, None, unknown, 16, 1)
    assert len(sets["generated"]) == 16 and "no word of whom the detector was trained with" in note
    older = write_drawn_set(tmp_path / "older", mean_shape(head_template), 4, 0)
    pupil: Any = SimpleNamespace(recipe={"people": {"train": "dddddddddddd", "validation": ""}})
    assert len(load_judged_sets(older, None, pupil, 4, 1)[0]["generated"]) == 4
