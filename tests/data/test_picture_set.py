import numpy as np

from caricli.data.picture_set import COLUMNS, PictureWriter, encode_labels, encode_picture, read_picture_set
from caricli.data.texture_set import SPLITS


def test_pictures_of_nobody_can_be_read_again(tmp_path):
    writer = PictureWriter(tmp_path)
    blank = np.zeros((8, 8), np.uint8)
    writer.add(encode_picture(np.zeros((8, 8, 3), np.uint8)), encode_labels(blank), "flat", [])
    writer.finish({"splits": dict.fromkeys(SPLITS, [])})
    pictures = read_picture_set(tmp_path)
    assert pictures.count == 1 and set(pictures.truth) == set(COLUMNS)
    assert not len(pictures.faces(0)) and pictures.picture(0).shape == (8, 8, 3)
