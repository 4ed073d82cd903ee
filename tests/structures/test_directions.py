import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures import Directions


def some():
    normals = np.array([[0.6, 0.8, 0, 0], [0, 0, -1.0, 0], [0.5, 0.5, 0.5, 0.5]])
    return Directions(
        names=("BigNose", "Smile", "rond"),
        normals=normals,
        gradients=0.5 * normals,
        auc=np.array([0.99, 1.0, 0.0]),
        positives=np.array([10, 0, 40]),
        count=40,
        cost=np.array([0.1, 1.0, 0.001]),
        change=np.array([0.9, -0.1, 0.0]),
        model_id="",
        recipe={},
        people=np.zeros((0, 4)),
    )


def test_nobody_need_be_there():
    assert some().people.shape == (0, 4)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"names": ("a", "b", "a")}, "names: expected a list of distinct names"),
        ({"names": ("a", "b", "")}, "names: expected a list of distinct names"),
        ({"names": ()}, "names: expected a list of distinct names"),
        ({"names": ("a", "b")}, r"names: expected the shape \(3,\), found \(2,\)"),
        ({"normals": np.ones(3)}, r"normals: expected \(A,D\), found \(3,\)"),
        ({"normals": np.zeros((3, 0))}, "normals: expected"),
        ({"normals": np.ones((3, 4))}, "normals: expected unit vectors, found lengths from 2 to 2"),
        ({"normals": np.zeros((3, 4))}, "normals: expected unit vectors"),
        ({"normals": np.eye(4)}, r"names: expected the shape \(4,\), found \(3,\)"),
        ({"normals": np.full((3, 4), np.nan)}, "normals: expected finite numbers"),
        ({"gradients": np.ones((3, 5))}, r"gradients: expected the shape \(3, 4\), found \(3, 5\)"),
        ({"gradients": np.full((3, 4), np.nan)}, "gradients: expected finite numbers"),
        ({"auc": np.array([0.5, 2, 0.5])}, "auc: expected numbers from 0 to 1"),
        ({"auc": np.array([0.5, -0.1, 0.5])}, "auc: expected numbers from 0 to 1"),
        ({"auc": np.ones(2)}, "auc: expected the shape"),
        ({"positives": np.array([1, 2, 41])}, "positives: expected numbers from 0 to 40"),
        ({"positives": np.array([1, -2, 4])}, "positives: expected numbers from 0 to 40"),
        ({"cost": np.array([1, np.inf, 1])}, "cost: expected finite numbers"),
        ({"change": np.array([0.5, np.inf, 0.5])}, "change: expected finite numbers"),
        ({"people": np.ones((2, 5))}, r"people: expected the shape \(2, 4\), found \(2, 5\)"),
        ({"people": np.full((2, 4), np.nan)}, "people: expected finite numbers"),
    ],
)
def test_what_are_no_directions_is_refused(changes, words):
    with pytest.raises(InputError, match=words) as caught:
        dataclasses.replace(some(), **changes)
    assert "\n" not in str(caught.value)
