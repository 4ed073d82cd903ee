import numpy as np

from caricli.render.backdrop import PAPER
from caricli.render.sheets.crop_portrait import crop_portrait


def test_the_square_around_the_landmarks():
    picture = np.zeros((200, 300, 3), np.uint8)
    picture[60:140, 160:240] = 255
    points = np.array([[160.0, 60], [240, 140], [np.nan, np.nan], [200, 100]])
    portrait = crop_portrait(picture, points, 64)
    assert portrait.shape == (64, 64, 3) and portrait[32, 32].tolist() == [255, 255, 255]
    white = (portrait > 127).all(-1)
    # 80 of 128 pixels.
    assert white.any(0).sum() == white.any(1).sum() == 40
    assert np.abs(np.argwhere(white).mean(0) - 31.5).max() < 1


def test_landmarks_count_from_the_middle_of_a_pixel():
    picture = np.zeros((21, 21, 3), np.uint8)
    picture[10, 10] = 255
    portrait = crop_portrait(picture, np.array([[0.0, 0], [20, 20]]), 640)
    rows, columns = np.nonzero(portrait[..., 0] > 127)
    assert abs(rows.mean() - 319.5) < 1 and abs(columns.mean() - 319.5) < 1


def test_beyond_the_picture_it_is_paper():
    portrait = crop_portrait(np.full((50, 50, 3), 200, np.uint8), np.array([[0.0, 0], [20, 20]]), 32)
    assert portrait[0, 0].tolist() == [*PAPER] and portrait[-1, -1].tolist() == [200, 200, 200]
