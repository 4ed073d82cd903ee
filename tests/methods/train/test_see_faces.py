from types import SimpleNamespace

import numpy as np

from caricli.methods.train.see_faces import domain_rows, see_faces


def test_faces_are_seen_from_random_sides(head_template):
    shapes = np.stack([head_template.vertices, head_template.vertices + 0.3])
    acts = np.array([[False, True, False]])
    one, other = (see_faces(s[None], acts, head_template, 5, np.random.default_rng(4)) for s in shapes)
    # Places do not matter; turns do.
    np.testing.assert_allclose(one.points, other.points, atol=1e-9)
    assert one.points.std(0).max() > 0.05 and one.labels.shape == (5, 9)
    assert (one.labels[:, [0, 2]] == 1).all() and (one.labels[:, [1, 3]] == 0).all()
    turns = one.labels[:, 4:6]
    np.testing.assert_allclose(one.labels[:, 6:], np.column_stack([turns**2, turns.prod(1)]))


def test_what_is_exaggerated_by_parts_alone_is_a_caricature():
    level, kind = np.array([1, 1, 3, 3]), np.array([0, 2, 1, 3])
    found = domain_rows(SimpleNamespace(level=level, factors={"kind": kind}))
    assert found["normal"].tolist() == [True, False, False, False]
    found = domain_rows(SimpleNamespace(level=level, factors={}))
    assert found["caricature"].tolist() == [False, False, True, True]
