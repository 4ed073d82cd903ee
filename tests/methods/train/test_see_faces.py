from types import SimpleNamespace

import numpy as np

from caricli.methods.train.see_faces import domain_rows, see_faces


def test_faces_are_seen_from_random_sides(head_template):
    shapes = np.stack([head_template.vertices, head_template.vertices + 0.3])
    one, other = (see_faces(shape[None], head_template, 5, np.random.default_rng(4)) for shape in shapes)
    # Places do not matter; turns do.
    assert one.shape == (5, 68, 2)
    np.testing.assert_allclose(one, other, atol=1e-9)
    assert one.std(0).max() > 0.05
    again = see_faces(shapes[:1], head_template, 5, np.random.default_rng(5))
    assert np.abs(again - one).max() > 0.05


def test_what_is_exaggerated_by_parts_alone_is_a_caricature():
    level, kind = np.array([1, 1, 3, 3]), np.array([0, 2, 1, 3])
    found = domain_rows(SimpleNamespace(level=level, factors={"kind": kind}))
    assert found["normal"].tolist() == [True, False, False, False]
    found = domain_rows(SimpleNamespace(level=level, factors={}))
    assert found["caricature"].tolist() == [False, False, True, True]
