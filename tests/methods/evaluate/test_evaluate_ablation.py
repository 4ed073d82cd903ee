from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.methods.evaluate.evaluate_ablation import (
    HYPERNETWORK,
    LINEAR,
    NETWORKS,
    POSITIONS,
    VERTICES_ONLY,
    evaluate_ablation,
    fit_codes,
)
from caricli.methods.evaluate.evaluate_shape import evaluate_shape
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, VertexArray
from caricli.models.deformable.model import UnitBox
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

CONFIG = AblationConfig(
    latent=4, width=16, layers=2, hidden=8, array_hidden=12, frequency=5.0, epochs=6, batch=8, points=60,
    learning_rate=5e-3, precision="float32", validate_every=3, code_steps=20,
)  # fmt: skip


@pytest.fixture(scope="module")
def template(ball):
    vertices, faces = ball
    annotation = parse_annotation({"ibug68": list(range(68))}, len(vertices), "ball")
    return Template(vertices, faces, annotation=annotation)


@pytest.fixture(scope="module")
def shapes(ball):
    """(30, 300, 3) smoothly bent balls."""
    generator, vertices = np.random.default_rng(11), ball[0]
    waves = [np.sin(vertices @ generator.normal(size=(3, 3)) + generator.normal(size=3)) for _ in range(5)]
    return (vertices + np.tensordot(generator.normal(0, 0.15, (30, 5)), waves, 1)).astype(np.float32)


@pytest.fixture(scope="module")
def meshes(template, shapes):
    surface = Surface(UnitBox(template.vertices), template.faces)
    return TrainingMeshes(surface, shapes[:24], shapes[24:])


@pytest.fixture(scope="module")
def rows(template, meshes):
    progress = []
    report = lambda done, total: progress.append((done, total))  # noqa: E731
    found = list(evaluate_ablation(template, meshes, CONFIG, report=report))
    assert progress == [(k, 30) for k in range(1, 31)]
    return {row.name: row for row in found}


def test_every_model_has_a_row_with_finite_errors(rows):
    assert list(rows) == [*NETWORKS, *LINEAR]
    for row in rows.values():
        assert row.parameters > 0 and row.seconds > 0
        assert all(0 < error < 100 for error in (row.train, row.test, row.surface))


def test_networks_have_curves_and_linear_models_none(rows):
    for name in NETWORKS:
        curves = rows[name].curves
        assert [epoch for epoch, _ in curves["train"]] == list(range(1, 7))
        assert [epoch for epoch, _ in curves["test"]] == [3, 6]
        assert curves["train"][-1][1] < curves["train"][0][1]
    assert all(rows[name].curves is None for name in LINEAR)


def test_codes_fitted_to_the_end_are_better_than_those_of_the_curve(rows):
    for name in NETWORKS:
        assert rows[name].test < 1.02 * rows[name].curves["test"][-1][1]


def test_only_the_points_differ_for_vertices_only(rows):
    hybrid, vertices = rows[HYPERNETWORK], rows[VERTICES_ONLY]
    assert hybrid.parameters == vertices.parameters and hybrid.test != vertices.test


def test_positions_begin_farther_away_than_displacements(rows):
    first = {name: row.curves["train"][0][1] for name, row in rows.items() if row.curves}
    assert max(first, key=first.get) == POSITIONS


def test_linear_models_are_measured_as_everywhere(rows, template, shapes):
    model = PcaModel.train(template, shapes[:24], PcaConfig(CONFIG.latent, CONFIG.seed))
    for error, part in ((rows["PCA"].train, shapes[:24]), (rows["PCA"].test, shapes[24:])):
        np.testing.assert_allclose(error, evaluate_shape(model, part).percent, rtol=1e-4)


def test_the_same_seed_gives_the_same_figures(rows, template, meshes):
    again = list(evaluate_ablation(template, meshes, CONFIG))
    for row in again:
        assert replace(row, seconds=0.0) == replace(rows[row.name], seconds=0.0)


def test_codes_reach_what_the_network_can_express(ball, shapes):
    generator = torch.Generator().manual_seed(0)
    network = VertexArray(ArraySize(CONFIG.latent, 12, len(ball[0])), CONFIG.latent_std, generator)
    surface = Surface(UnitBox(ball[0]), ball[1])
    points = surface.at_vertices()
    truth = CONFIG.latent_std * torch.randn(3, CONFIG.latent, generator=generator)
    with torch.no_grad():
        fields = network(truth, points).numpy()
    unseen = fields / surface.box.scale + ball[0]
    training = AutoDecoderTraining(network, TrainingMeshes(surface, shapes[:6], unseen), CONFIG)
    network.requires_grad_(False)
    start = network(training.codes, points) - training.unseen
    end = network(fit_codes(training, 300), points) - training.unseen
    assert end.norm() < 0.02 * start.norm()
    assert not training.codes.any()
