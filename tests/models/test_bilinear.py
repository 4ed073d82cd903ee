import numpy as np
import pytest

from caricli.errors import InputError, NumericsError
from caricli.models.bilinear.config import BilinearConfig
from caricli.models.bilinear.model import BilinearModel
from caricli.models.bilinear.n_mode_svd import n_mode_svd
from caricli.models.bilinear.space import BilinearSpace
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint


@pytest.fixture(scope="module")
def grid(balls):
    """(12, 6, 300, 3): twelve balls with six bumps, the larger the ball's own weight; rank four by three, and noise."""
    generator = np.random.default_rng(5)
    who = np.stack([balls[0], *generator.normal(0, 0.1, (3, 300, 3))])
    u = np.concatenate([generator.normal(1, 0.1, (12, 1)), generator.normal(size=(12, 3))], 1)
    what = np.concatenate([np.ones((1, 4, 300, 1)), generator.normal(0, 0.2, (2, 4, 300, 1))])
    v = np.concatenate([np.ones((6, 1)), generator.normal(size=(6, 2))], 1)
    exact = np.einsum("pi,ek,kivx,ivx->pevx", u, v, what, who)
    return exact + generator.normal(0, 1e-4, exact.shape)


@pytest.fixture(scope="module")
def model(ball_template, grid):
    return BilinearModel.train(ball_template, grid, BilinearConfig(4, 3))


def test_a_slow_decomposition_agrees(grid):
    """The modes are the singular vectors of the unfolded tables, and the core what is left of the table in them."""
    table = grid.reshape(12, 6, -1)
    modes = n_mode_svd(table, 4, 3)
    people = np.linalg.svd(table.reshape(12, -1), full_matrices=False)[0][:, :4]
    expressions = np.linalg.svd(table.swapaxes(0, 1).reshape(6, -1), full_matrices=False)[0][:, :3]
    for own, expected in ((modes.people, people), (modes.expressions, expressions)):
        assert np.abs(np.abs(np.sum(own * expected, 0)) - 1).max() < 1e-6
    core = np.einsum("pem,pi,ek->mik", table, modes.people, modes.expressions)
    assert np.abs(modes.core - core).max() < 1e-9
    assert (modes.people.sum(0) > 0).all() and (modes.expressions.sum(0) > 0).all()
    rebuilt = np.einsum("mik,pi,ek->pem", modes.core, modes.people, modes.expressions)
    assert np.abs(rebuilt - table).max() < 1e-3


def test_faces_of_the_rank_of_the_model_are_held(model, grid):
    shapes = grid.reshape(-1, 300, 3)
    assert len(model.prior.mean) == 4 + 3 - 1
    assert np.abs(model.decode(model.encode(shapes)) - shapes).max() < 1e-3
    assert model.space.noise == pytest.approx(1e-4, rel=0.2)


def test_a_face_is_linear_in_who_and_linear_in_what(model):
    first, second = model.prior.sample(np.random.default_rng(0), 2)
    for own in (slice(0, 4), slice(4, None)):
        other = first.copy()
        other[own] = second[own]
        middle = (first + other) / 2
        assert np.abs(model.decode(middle) - (model.decode(first) + model.decode(other)) / 2).max() < 1e-12
    assert np.abs(model.decode(first + second) - model.decode(first) - model.decode(second)).max() > 1e-3


def test_encode_undoes_decode(model):
    latents = model.prior.sample(np.random.default_rng(1), 8)
    again = model.encode(model.decode(latents).reshape(2, 4, 300, 3)).reshape(8, -1)
    assert np.sqrt(((model.prior.whiten(again) - model.prior.whiten(latents)) ** 2).mean()) < 0.05


def test_encode_is_the_likeliest_latent(model, grid):
    space = BilinearSpace(model.space.core, model.prior, noise=0.5)
    row = (grid[3, 2].ravel() @ model._projector.T)[None]
    code = space.encode(row)[0]

    def cost(z):
        return ((space.decode(z) - row) ** 2).sum() + 0.5**2 * (model.prior.whiten(z) ** 2).sum()

    steps = 1e-3 * model.prior.factor.T
    assert all(cost(code) < cost(code + step) for step in (*steps, *-steps))


def test_what_is_not_known_does_not_count(model, grid):
    rows = grid[:2, :3].reshape(6, -1) @ model._projector.T
    weights = np.ones_like(rows)
    weights[:, -1] = 0
    spoilt = rows.copy()
    spoilt[:, -1] = 5
    assert np.abs(model.space.encode(spoilt, weights) - model.space.encode(rows, weights)).max() < 1e-6
    assert np.abs(model.space.encode(spoilt) - model.space.encode(rows)).max() > 1e-2


def test_rows_are_encoded_together_as_one_by_one(model, grid):
    """Some settle sooner than others, and each knows other numbers."""
    rows = grid[:4, :3].reshape(12, -1) @ model._projector.T
    rows += np.linspace(0, 3, 12)[:, None] * np.random.default_rng(3).normal(size=rows.shape)
    weights = np.random.default_rng(4).uniform(0.1, 1, rows.shape)
    together = model.space.encode(rows, weights)
    alone = [model.space.encode(rows[[k]], weights[[k]])[0] for k in range(12)]
    assert np.abs(model.prior.whiten(together) - model.prior.whiten(np.array(alone))).max() < 1e-6


def test_the_training_latents_are_white(model, grid):
    whitened = model.prior.whiten(model.encode(grid.reshape(-1, 300, 3)))
    assert np.abs(whitened.mean(0)).max() < 1e-3
    assert np.abs(np.cov(whitened.T) - np.eye(whitened.shape[1])).max() < 1e-2


def test_the_jacobian_agrees_with_finite_differences(model):
    points = np.array([7, 3, 250])
    latent = model.prior.sample(np.random.default_rng(2), 1)[0]
    positions, jacobian = model.points_jacobian(latent, points)
    assert np.abs(positions - model.decode(latent)[points]).max() < 1e-12
    for k, direction in enumerate(np.eye(len(latent))):
        ends = [model.decode_points(latent + sign * 1e-4 * direction, points) for sign in (1, -1)]
        assert np.abs(jacobian[..., k] - (ends[0] - ends[1]) / 2e-4).max() < 1e-8


def test_more_faces_lie_between_two(model, grid):
    latents = model.encode(grid[:2, 0])
    more = model.between(latents, 50, np.random.default_rng(0))
    assert more.shape == (50, len(latents[0]))
    low, high = latents.min(0) - 1e-12, latents.max(0) + 1e-12
    assert ((more >= low) & (more <= high)).all() and np.ptp(more, axis=0).max() > 0
    # Each somewhere else between the two, and all of it at one place.
    apart = latents[1] - latents[0]
    shares = (more - latents[0]) @ apart / (apart @ apart)
    np.testing.assert_allclose(more, latents[0] + shares[:, None] * apart, atol=1e-12)
    inner = np.sort(shares[(shares > 0) & (shares < 1)])
    assert len(inner) > 15 and np.diff(inner).min() > 0


def test_a_checkpoint_rebuilds_it(model, grid):
    again = model_from_checkpoint(*model_to_checkpoint(model, {}), "m")
    assert again.kind == "bilinear"
    shapes = grid[:, 0]
    assert np.abs(again.decode(model.encode(shapes)) - model.decode(model.encode(shapes))).max() < 1e-3


def test_no_more_dimensions_than_the_data_have(ball_template, grid):
    small = BilinearModel.train(ball_template, grid[:3, :1], BilinearConfig())
    assert len(small.prior.mean) == 3
    assert np.isfinite(small.decode(small.prior.mean)).all()


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("first", lambda a: a[:-1]),
        ("basis", lambda a: a[:, :-1]),
        ("core", lambda a: a[:-1]),
        ("code", lambda a: a[:-1]),
        ("factor", lambda a: a[:-1]),
        ("noise", lambda a: a * 0),
    ],
)
def test_tensors_that_do_not_fit_are_refused(model, name, change):
    tensors, metadata = model_to_checkpoint(model, {})
    with pytest.raises(InputError, match="m: not a valid model"):
        model_from_checkpoint(tensors | {f"model.{name}": change(tensors[f"model.{name}"])}, metadata, "m")
    del tensors[f"model.{name}"]
    with pytest.raises(InputError, match="m: not a valid model"):
        model_from_checkpoint(tensors, metadata, "m")


def test_faces_that_are_all_the_same_are_refused(ball_template, grid):
    with pytest.raises(NumericsError, match="differ"):
        BilinearModel.train(ball_template, np.repeat(grid[:1], 4, axis=0)[:, :1], BilinearConfig())
