import numpy as np
import pytest

from caricli.methods.faces.dataset_sheet import dataset_sheet


@pytest.fixture(scope="module")
def shapes(head_template):
    stretch = np.random.default_rng(0).uniform(0.7, 1.3, (3, 1, 3))
    return head_template.vertices * stretch, head_template


def sheet(shapes, count=1, seed=0, size=40):
    vertices, template = shapes
    return dataset_sheet(vertices, template, count, size, np.random.default_rng(seed))


def test_every_face_has_two_views(shapes):
    one, three = sheet(shapes, 1), sheet(shapes, 3)
    assert one.dtype == np.uint8 and one.shape[1] >= 80 and 40 <= one.shape[0] < 80
    left, right = one[:, : one.shape[1] // 2], one[:, one.shape[1] // 2 :]
    assert (left < 205).any(-1).sum() > 100 and (right < 205).any(-1).sum() > 100
    assert three.size > 2 * one.size


def test_the_generator_chooses(shapes):
    np.testing.assert_array_equal(sheet(shapes), sheet(shapes))
    assert any((sheet(shapes, seed=seed) != sheet(shapes)).any() for seed in (1, 2, 3))


def test_no_more_faces_than_there_are(shapes):
    np.testing.assert_array_equal(sheet(shapes, 400), sheet(shapes, 3, seed=5))
