import numpy as np

from caricli.methods.pictures.held import hold_before
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape


def test_what_is_held_covers_a_part_of_a_face_and_is_labelled(head_template):
    points = 100 + 200 * mean_shape(head_template) / np.ptp(mean_shape(head_template))
    points = points - points.mean(0) + 150
    covered = []
    for seed in range(30):
        image = np.full((300, 300, 3), 0.5, np.float32)
        region = np.full((300, 300), Region.SKIN, np.uint8)
        hold_before(image, region, points, np.array([0.9, 0.5, 0.3]), np.random.default_rng(seed))
        other = region == Region.OTHER
        assert set(np.unique(region)) <= {Region.SKIN, Region.OTHER} and other.any()
        assert np.abs(image - 0.5).max(2)[other].mean() > 0.02
        changed = np.abs(image - 0.5).max(2) > 1e-3
        # Its border is smooth: half a pixel of it on either side.
        assert (changed & ~other).sum() < 0.25 * other.sum() + 60
        at = np.round(points).astype(int)
        covered.append(other[at[:, 1], at[:, 0]].mean())
    assert 0.05 < np.mean(covered) < 0.7
