import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.edit.map_landmarks import map_landmarks, mean_shift
from caricli.models.landmark_map.model import align
from caricli.store.landmark_maps import load_landmark_map


@pytest.fixture(scope="module")
def bundled():
    return load_landmark_map()


@pytest.fixture
def points(head_template):
    """81 landmarks of the head from the front, in pixels."""
    return 1000 * head_template.vertices[head_template.annotation.landmarks][:, :2] * [1, -1] + 200


def test_there_and_back_is_where_it_began(bundled, points):
    for first, second in (("normal", "caricature"), ("caricature", "normal")):
        back = map_landmarks(map_landmarks(points, bundled, first), bundled, second)
        error = np.linalg.norm(back - points[:68], axis=1).mean() / np.linalg.norm(np.ptp(points[:68], axis=0))
        assert error < 0.02


def test_a_caricature_becomes_more_normal(bundled, points):
    aligned = align(points[:68])[0]
    mean = bundled.normal.reshape(68, 2)
    wild = mean + 4 * (aligned - mean)
    tame = map_landmarks(wild, bundled, "normal")
    assert np.linalg.norm(align(tame)[0] - mean) < 0.7 * np.linalg.norm(align(wild)[0] - mean)


def test_only_the_68_are_mapped(bundled, points):
    np.testing.assert_array_equal(
        map_landmarks(points, bundled, "normal"), map_landmarks(points[:68], bundled, "normal")
    )
    points[70] = np.nan
    assert np.isfinite(map_landmarks(points, bundled, "normal")).all()


def test_unknown_and_missing_landmarks_are_refused(bundled, points):
    points[[5, 7]] = np.nan
    with pytest.raises(InputError, match="found 66, not landmark 5"):
        map_landmarks(points, bundled, "normal")
    with pytest.raises(InputError, match="found 20"):
        map_landmarks(points[10:30], bundled, "normal")


def test_the_shift_is_in_percent_of_the_diagonal(points):
    diagonal = np.linalg.norm(np.ptp(points[:68], axis=0))
    assert mean_shift(points, points[:68] + [0.03 * diagonal, 0]) == pytest.approx(3)
