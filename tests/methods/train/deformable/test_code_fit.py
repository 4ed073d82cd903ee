import numpy as np
import pytest
import torch

from caricli.methods.train.deformable.code_fit import CodeFit, square_distances
from caricli.methods.train.deformable.surface import Surface
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox

CONFIG = DeformableConfig(latent=2, data_weight=1.0, latent_std=1.0)


class Linear(torch.nn.Module):
    """Displacements that are linear in a latent of two numbers."""

    def forward(self, latents, points):
        return latents[:, None, :1] * points.positions + latents[:, None, 1:] * points.positions.roll(1, -1)


@pytest.fixture(scope="module")
def points(ball):
    return Surface(UnitBox(ball[0]), ball[1]).at_vertices()


def test_codes_go_down_to_those_of_the_shapes(points):
    truth = torch.tensor([[0.3, -0.2], [0.1, 0.4]])
    fields = Linear()(truth, points)
    fit = CodeFit(torch.zeros(2, 2), 0.05, CONFIG)
    start = fit.codes.detach().clone()
    for _ in range(200):
        fit.step(Linear(), points, fields)
    assert torch.allclose(fit.codes, truth, atol=1e-3) and not start.any()
    assert square_distances(Linear(), fit.codes, points, fields).max() < 1e-5


def test_the_codes_that_it_starts_from_stay_as_they_are(points):
    codes = torch.ones(1, 2)
    CodeFit(codes, 0.1, CONFIG).step(Linear(), points, torch.zeros(1, len(points.positions), 3))
    np.testing.assert_array_equal(codes.numpy(), 1)
