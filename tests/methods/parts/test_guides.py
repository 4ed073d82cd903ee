import numpy as np

from caricli.methods.parts.guides import Guides


def test_what_may_be_near_a_wall_is_told_by_few_points():
    shape = np.random.default_rng(1).uniform(-1, 1, (2000, 3))
    guides = Guides(shape, 0.2)
    asked = []

    def distance(points):
        asked.append(len(points))
        return points[:, 1] + 1

    # A part may be larger in a face than where guides were chosen.
    for size in (1.0, 1.5):
        near = guides.near(size * shape, 0.1, lambda points, size=size: distance(points / size) * size)
        truly = size * (shape[:, 1] + 1) < 0.1
        assert truly[near].sum() == truly.sum() > 50
        assert len(near) < 0.3 * len(shape)
    assert max(asked) < 0.25 * len(shape)
