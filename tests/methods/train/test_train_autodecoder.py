import io
from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import NumericsError
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox
from caricli.models.deformable.networks import HyperSiren

CONFIG = DeformableConfig(
    latent=4, width=24, layers=2, hidden=16, frequency=5.0, epochs=30, batch=8, points=60, learning_rate=5e-3,
    precision="float32", validate_every=5,
)  # fmt: skip


@pytest.fixture(scope="module")
def shapes(ball):
    """Ellipsoids that lean: three numbers each."""
    vertices = ball[0]
    generator = np.random.default_rng(0)
    scales = 1 + 0.2 * generator.normal(size=(30, 1, 3))
    return (vertices * scales + 0.1 * scales[:, :, :1] * vertices[:, [1, 2, 0]]).astype(np.float32)


def training(ball, shapes, config=CONFIG, unseen=5, share=ALL):
    network = HyperSiren(config.size(), torch.Generator().manual_seed(config.seed))
    count = len(shapes) - unseen
    meshes = TrainingMeshes(Surface(UnitBox(ball[0]), ball[1]), shapes[:count], shapes[count:])
    return AutoDecoderTraining(network, meshes, config, share)


def weights(run):
    return torch.cat([p.detach().flatten() for p in [*run.network.parameters(), run.latents, run.codes]])


@pytest.mark.slow
@pytest.mark.parametrize("start", ["principal", "random"])
def test_it_learns_shapes_that_it_has_not_seen(ball, shapes, start):
    records = list(training(ball, shapes, replace(CONFIG, start=start, epochs=150, mixup=0.0)).epochs())
    assert [r.epoch for r in records] == list(range(1, 151))
    spread = np.linalg.norm(shapes - shapes.mean(0), axis=-1).mean()
    assert records[-1].train_error < 0.4 * spread
    validations = [r.validation_error for r in records if r.validation_error is not None]
    assert len(validations) == 30
    assert validations[-1] < (0.3 if start == "principal" else 0.6) * spread


@pytest.mark.parametrize("start", ["principal", "random"])
def test_it_comes_nearer_to_shapes_that_it_has_not_seen(ball, shapes, start):
    records = list(training(ball, shapes, replace(CONFIG, start=start, mixup=0.0)).epochs())
    assert [r.epoch for r in records] == list(range(1, 31))
    validations = [r.validation_error for r in records if r.validation_error is not None]
    assert len(validations) == 6
    assert validations[-1] < (0.8 if start == "principal" else 0.9) * validations[0]
    assert records[-1].train_error < 0.8 * records[0].train_error


def test_resumed_training_ends_in_the_same_weights(ball, shapes):
    whole = training(ball, shapes)
    all_records = list(whole.epochs())
    run, records = training(ball, shapes), []
    for stop in (3, 10, 11, 30):
        for record in run.epochs():
            records.append(record)
            if record.epoch == stop:
                break
        saved = io.BytesIO()
        torch.save(run.state(), saved)
        saved.seek(0)
        run = training(ball, shapes)
        run.load_state(torch.load(saved, weights_only=True))
    assert records == all_records
    assert torch.equal(weights(run), weights(whole))


def test_another_seed_gives_other_weights(ball, shapes):
    one, two = (training(ball, shapes, replace(CONFIG, epochs=1, seed=seed)) for seed in (0, 1))
    list(one.epochs()), list(two.epochs())
    assert not torch.equal(weights(one), weights(two))


def test_shares_of_a_batch_sum_to_the_whole_gradient(ball, shapes, monkeypatch):
    gradients, figures = [], []

    def keep(run, part):
        figures.append(part)
        gradients.append(torch.cat([p.grad.flatten() for p in [*run.network.parameters(), run.latents]]))
        return part

    monkeypatch.setattr(AutoDecoderTraining, "_sum_over_processes", keep)
    for process in range(3):
        training(ball, shapes, share=Share(process, 3))._step(torch.arange(8), 0)
    alone = training(ball, shapes)
    figure = alone._step(torch.arange(8), 0)
    whole = torch.cat([p.grad.flatten() for p in [*alone.network.parameters(), alone.latents]])
    assert torch.allclose(sum(gradients), whole, rtol=1e-4, atol=1e-5 * float(whole.abs().max()))
    assert torch.allclose(sum(figures), figure, rtol=1e-5)


def test_patience_ends_it(ball, shapes, monkeypatch):
    run = training(ball, shapes, replace(CONFIG, validate_every=2, patience=3))
    errors = iter([1.0, 0.8, 0.9, 0.7, 0.8, 0.7, 0.9, 0.1])
    monkeypatch.setattr(run, "_validate", lambda: next(errors))
    records = list(run.epochs())
    assert [r.epoch for r in records if r.best] == [2, 4, 8]
    assert records[-1].epoch == 14 and run.ended


def test_a_loss_that_is_not_finite_stops_it_before_the_weights_are_touched(ball, shapes):
    run = training(ball, shapes)
    list(zip(range(2), run.epochs(), strict=False))
    before = weights(run)
    run.shapes[:] = torch.nan
    with pytest.raises(NumericsError, match="epoch 3 is not finite"):
        list(run.epochs())
    assert torch.equal(weights(run), before) and torch.isfinite(before).all()


def mixtures(run):
    """Latents between shapes that are trained with, and the shapes that are aimed at there."""
    angles = torch.full((24,), 0.8)
    return run._mixtures(torch.arange(24), torch.arange(1, 25), angles, run.surface.at_vertices())


def test_mixtures_lie_on_arcs_from_shape_to_shape_around_the_mean(ball, shapes):
    run = training(ball, shapes)
    _, aims = mixtures(run)
    mean, cosine, sine = run.shapes.mean(0), np.cos(0.8), np.sin(0.8)
    expected = mean + cosine * (run.shapes[:24] - mean) + sine * (run.shapes[1:25] - mean)
    assert torch.allclose(aims, expected, atol=1e-5)


@pytest.mark.slow
def test_mixup_teaches_what_lies_between_two_shapes(ball, shapes):
    errors = []
    for mixup in (0.0, 1.0):
        run = training(ball, shapes, replace(CONFIG, mixup=mixup, epochs=150, noise=0.0, smoothness_weight=0.0))
        list(run.epochs())
        latents, aims = mixtures(run)
        with torch.no_grad():
            errors.append(float((run.network(latents, run.surface.at_vertices()) - aims).norm(dim=-1).mean()))
    assert errors[1] < 0.9 * errors[0]


def test_the_prior_term_keeps_latents_white(ball, shapes):
    def moments(prior_weight):
        run = training(ball, shapes, replace(CONFIG, prior_weight=prior_weight, latent_rate=0.05))
        list(run.epochs())
        spread = run.latents.detach() / CONFIG.latent_std
        return (spread.mT @ spread / len(spread) - torch.eye(4)).norm()

    assert moments(100.0) < 0.5 * moments(0.0)


def test_smoothness_at_drawn_latents_lowers_their_roughness(ball, shapes):
    def roughness(weight):
        run = training(ball, shapes, replace(CONFIG, smoothness_weight=weight))
        list(run.epochs())
        drawn = CONFIG.latent_std * torch.randn(50, 4, generator=torch.Generator().manual_seed(5))
        measure = training(ball, shapes, replace(CONFIG, smoothness_weight=1.0)).roughness
        with torch.no_grad():
            return float(measure(run.network, drawn, np.random.default_rng(0)))

    assert roughness(10.0) < 0.8 * roughness(0.0)
