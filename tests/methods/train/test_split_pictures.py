import numpy as np

from caricli.data.picture_set import read_picture_set
from caricli.methods.train.split_pictures import JoinedPictures, SplitPictures
from tests.drawn_pictures import mean_shape, write_drawn_set


def test_joined_pictures_are_those_of_each_and_of_one_split_alone(head_template, tmp_path):
    shape = mean_shape(head_template)
    sets = [read_picture_set(write_drawn_set(tmp_path / str(k), shape, 8 + 4 * k, k)) for k in range(2)]
    parts = [SplitPictures(pictures, "train") for pictures in sets]
    joined = JoinedPictures(parts)
    assert len(joined.numbers) == sum(len(part.numbers) for part in parts)
    assert len(joined.faces) == sum(len(part.faces) for part in parts)
    assert set(joined.numbers) >= {number for number, _ in joined.faces}
    for part, start in zip(parts, (0, 8), strict=True):
        for number in part.numbers:
            own = part.marked(number)
            same = joined.marked(start + number)
            np.testing.assert_array_equal(same.pixels, own.pixels)
            np.testing.assert_array_equal(same.landmarks, own.landmarks)
