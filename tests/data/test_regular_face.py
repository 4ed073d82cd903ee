from dataclasses import replace

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.data.expressions import named_expressions
from caricli.data.identities import random_identity
from caricli.data.regular_face import align_person, has_partners, regular_face, regular_faces


@pytest.fixture(scope="module")
def data(grid):
    return read_dataset(grid[0])


def test_they_are_the_faces_of_the_first_level(data):
    rows = np.flatnonzero(data.level == 3)
    first = [np.flatnonzero(_same_face(data, row) & (data.level == 1))[0] for row in rows]
    expected = data.vertices[first]
    faces = np.array([data.template.cavities.tuck(face) for face in regular_faces(data, rows)])
    assert faces.shape == expected.shape
    assert np.abs(faces - expected).max() < 1e-5


def _same_face(data, row):
    return (data.identity == data.identity[row]) & (data.expression == data.expression[row])


def test_all_can_show_one_expression(data):
    rows = np.flatnonzero(data.identity == 0)
    faces = regular_faces(data, rows, expression=0)
    assert (faces == faces[0]).all()
    calm = rows[data.expression[rows] == 0]
    assert np.array_equal(regular_faces(data, calm)[0], faces[0])


def test_the_neutral_face_lies_as_near_to_the_template_s_as_can_be(head, head_template):
    identity = random_identity(head, np.random.default_rng(3))
    neutral = head.evaluate(**vars(identity))
    person = align_person(identity, neutral, head_template)
    assert np.linalg.det(person.rotation) == pytest.approx(1)
    place = head_template.region("face")
    aligned = person.place(neutral)[place]
    assert np.linalg.norm(aligned.mean(0) - head_template.vertices[place].mean(0)) < 1e-9
    again = align_person(identity, person.place(neutral), head_template)
    assert again.scale == pytest.approx(1)
    np.testing.assert_allclose(again.rotation, np.eye(3), atol=1e-9)


def test_expressions_of_a_person_share_one_place(head, head_template):
    identity = random_identity(head, np.random.default_rng(3))
    person = align_person(identity, head.evaluate(**vars(identity)), head_template)
    actions = named_expressions(head.action_names)
    calm = regular_face(person, actions["neutral"], head)
    smile = regular_face(person, actions["smile"], head)
    still = np.linalg.norm(smile - calm, axis=1) < 1e-12
    # The skull does not move with the mouth.
    assert still.mean() > 0.3 and not still.all()


def test_a_dataset_without_its_factors_has_no_partners(data):
    assert has_partners(data)
    factors = {name: column for name, column in data.factors.items() if name != "changes"}
    assert not has_partners(replace(data, factors=factors))
