import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Mesh

SQUARE = np.array([[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def painted(uvs=SQUARE, uv_faces=HALVES):
    return Mesh(np.c_[SQUARE, np.zeros(4)], HALVES, uvs, uv_faces)


def test_texels_know_their_place():
    face, barycentric = uv_map(painted(), 64)
    inside = face >= 0
    assert inside[16:48, 16:48].all() and inside.sum() == 32 * 32
    assert face[47, 40] == 0 and face[18, 20] == 1  # row 0 is the top, v = 1
    place = (barycentric[..., None] * SQUARE[HALVES[face]]).sum(2)[inside]
    row, column = np.nonzero(inside)
    np.testing.assert_allclose(place, np.column_stack([column + 0.5, 63.5 - row]) / 64, atol=1e-6)
    assert not barycentric[~inside].any()


def test_every_triangle_of_the_head_is_there(head_template):
    face, barycentric = uv_map(head_template, 512)
    seen = np.unique(face[face >= 0], return_counts=True)
    a, b, c = np.moveaxis(head_template.uvs[head_template.uv_faces] * 512, 1, 0)
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert np.isin(np.flatnonzero(area > 8), seen[0]).all()
    assert seen[1].sum() == pytest.approx(area.sum(), rel=0.02)
    np.testing.assert_allclose(barycentric.sum(2), face >= 0, atol=1e-5)


def test_bad_meshes_are_refused():
    with pytest.raises(InputError):
        uv_map(painted(np.where(SQUARE > 0.5, np.nan, SQUARE)), 16)
    with pytest.raises(InputError):
        uv_map(painted(uv_faces=HALVES + 2), 16)
    with pytest.raises(InputError, match="without"):
        uv_map(painted(None, None), 16)


def test_padding_keeps_what_is_there_and_takes_the_nearest():
    image = np.arange(36).reshape(6, 6)
    covered = np.zeros((6, 6), bool)
    covered[2, 1] = covered[3, 4] = True
    padded = pad_texture(image, covered)
    assert padded[2, 1] == image[2, 1] and padded[3, 4] == image[3, 4]
    assert padded[0, 0] == image[2, 1] and padded[5, 5] == image[3, 4]
    assert set(padded.ravel()) == {image[2, 1], image[3, 4]}
    assert np.array_equal(pad_texture(image, covered & False), image)
    assert pad_texture(np.stack([image] * 3, -1), covered).shape == (6, 6, 3)
