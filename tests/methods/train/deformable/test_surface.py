import numpy as np
import pytest
import torch

from caricli.methods.train.deformable.surface import Surface
from caricli.models.deformable.model import UnitBox


@pytest.fixture(scope="module")
def surface(ball):
    return Surface(UnitBox(ball[0]), ball[1])


def test_drawn_points_lie_on_their_triangles_and_cover_the_surface(surface):
    points = surface.draw(4000, 0.25, np.random.default_rng(0))
    assert len(points.positions) == 4000
    # No more than all vertices, each once; the others on the surface.
    assert torch.allclose(points.values(surface.vertices), points.positions, atol=1e-6)
    assert len(torch.unique(points.corners[:300, 0])) == 300
    assert torch.allclose(points.weights.sum(1), torch.ones(4000), atol=1e-5) and points.weights.min() >= 0
    upper = (points.positions[300:, 1] > 0).float().mean()
    assert 0.45 < upper < 0.55


def test_where_all_points_are_to_be_vertices_there_are_no_others(surface):
    drawn = surface.draw(4000, 1.0, np.random.default_rng(0))
    assert sorted(drawn.corners[:, 0].tolist()) == list(range(len(surface.vertices)))
    assert (drawn.weights == torch.tensor([1.0, 0.0, 0.0])).all()


def test_all_vertices_are_there_in_their_order(surface, ball):
    points = surface.at_vertices()
    assert torch.equal(points.positions, surface.vertices) and len(points.positions) == len(ball[0])
    fields = torch.arange(3 * len(ball[0]), dtype=torch.float32).reshape(-1, 3)
    assert torch.equal(points.values(fields), fields)


def test_displacements_are_in_the_units_of_the_box(surface, ball):
    moved = ball[0] + [0.0, 0.5, 0.0]
    fields = surface.displacements(moved[None])[0].numpy()
    np.testing.assert_allclose(fields, [[0, 0.5 * surface.box.scale, 0]] * len(moved), atol=1e-6)
