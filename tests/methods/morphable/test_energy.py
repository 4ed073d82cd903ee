import numpy as np
import pytest
import torch

from caricli.methods.morphable.energy import SIDE, EnergyWeights, Observed, energy, landmark_loss
from caricli.methods.morphable.renderer import MorphableRenderer
from caricli.store.models import load_morphable

PIXELS = 64


@pytest.fixture(scope="module")
def renderer():
    return MorphableRenderer(load_morphable(), torch.float64)


@pytest.fixture(scope="module")
def truth(renderer):
    """(coefficients (2, D), what two pictures of them show)."""
    generator = np.random.default_rng(1)
    x = torch.zeros(2, renderer.layout.size, dtype=torch.float64)
    parts = renderer.layout.parts(x)
    x[:, : renderer.layout.face] = torch.as_tensor(0.5 * generator.normal(size=(2, renderer.layout.face)))
    parts["light"][:] = torch.tensor([2.5, 0.5, -0.5, -1.0, 0, 0, 0, 0, 0])
    parts["pose"][:] = torch.tensor([[0.1, 0.3, 0.0, 31, 30, 200], [0.0, -0.2, 0.1, 32, 33, 210]])
    posed = renderer.pose(x)
    sight = renderer.look(posed, PIXELS, PIXELS)
    images = torch.zeros(2, PIXELS, PIXELS, 3, dtype=torch.float64)
    images[sight.picture, sight.row, sight.column] = renderer.paint(posed, sight)
    confidence = torch.as_tensor(generator.uniform(size=(2, PIXELS, PIXELS)))
    points = renderer.landmarks(posed, renderer.anchors(posed, 68)).clone()
    points[0, 7] = torch.nan
    return x, Observed(images, confidence, points)


def test_a_picture_of_the_coefficients_leaves_the_regularisation_alone(renderer, truth):
    x, observed = truth
    found = energy(renderer, x, observed)
    parts = renderer.layout.parts(x.numpy())
    expected = [sum(w * (parts[name][k] ** 2).sum() for name, w in (("identity", 1.2), ("expression", 1.0),
                ("albedo", 1.2e-3))) for k in range(2)]  # fmt: skip
    np.testing.assert_allclose(found.regularisation.numpy(), expected)
    assert found.landmarks.abs().max() < 1e-20 and found.photometric.abs().max() < 1e-20
    np.testing.assert_allclose(found.total.numpy(), 3e-4 * np.array(expected))


def test_every_term_is_what_loops_make_of_it(renderer, truth):
    x, observed = truth
    other = x.clone()
    other[:, : renderer.layout.face] *= 0.5
    found = energy(renderer, other, observed, EnergyWeights())
    posed = renderer.pose(other)
    marks = renderer.landmarks(posed, renderer.anchors(posed, 68)).numpy()
    sight = renderer.look(posed, PIXELS, PIXELS)
    colours = renderer.paint(posed, sight).numpy()
    for number in range(2):
        pairs = zip(marks[number], observed.points[number].numpy(), strict=True)
        squares = [((a - b) ** 2).sum() for a, b in pairs if np.isfinite(b).all()]
        assert len(squares) == 68 - (number == 0)
        assert found.landmarks[number].item() == pytest.approx(np.mean(squares) * (SIDE / PIXELS) ** 2)
        total = weight = 0.0
        for k in np.flatnonzero(sight.picture.numpy() == number):
            at = number, sight.row[k], sight.column[k]
            sure = observed.confidence[at].item()
            total += ((sure * (colours[k] - observed.images[at].numpy())) ** 2).sum()
            weight += sure
        assert found.photometric[number].item() == pytest.approx(total / weight)
    together = 2e-3 * found.landmarks + 2.0 * found.photometric + 3e-4 * found.regularisation
    np.testing.assert_allclose(found.total.numpy(), together.numpy())


def test_its_derivatives_lead_downhill(renderer, truth):
    x, observed = truth
    start = x.clone()
    start[:, : renderer.layout.face] *= 0.5
    start.requires_grad_()
    before = energy(renderer, start, observed).total
    (gradient,) = torch.autograd.grad(before.sum(), start)
    # Pixels and metres differ by orders of magnitude; the face's coefficients do not.
    gradient[:, renderer.layout.face :] = 0
    slope = (gradient**2).sum(1)
    after = energy(renderer, start.detach() - 1e-5 * gradient / slope[:, None].sqrt(), observed).total
    assert ((before - after) / (1e-5 * slope.sqrt())).detach().numpy() == pytest.approx(1, rel=0.02)


def test_no_known_landmark_and_no_sight_cost_nothing(renderer, truth):
    x, observed = truth
    nowhere = torch.full_like(observed.points, torch.nan)
    away = x.clone()
    renderer.layout.parts(away)["pose"][:, 3] += 1000
    found = energy(renderer, away, Observed(observed.images, observed.confidence, nowhere))
    assert not found.landmarks.any() and not found.photometric.any()


def test_landmarks_count_by_their_weights():
    points = torch.tensor([[[0.0, 0.0], [4.0, 0.0]]])
    projected = torch.tensor([[[3.0, 4.0], [4.0, 2.0]]], requires_grad=True)
    loss = landmark_loss(projected, points, torch.tensor([[2.0, 0.5]]))
    assert loss.item() == (2 * 25 + 0.5 * 4) / 2
    unknown = landmark_loss(projected, torch.full((1, 2, 2), torch.nan))
    assert not torch.autograd.grad(unknown.sum(), projected)[0].any()
