"""Small models of every kind that one call trains on shapes."""

from dataclasses import dataclass, field, fields
from functools import cache

import numpy as np
import pytest

from caricli.models.kinds import config_class, model_class
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

DIMENSION = 12


@dataclass(frozen=True)
class Tested:
    """How near a kind must come, and how it is trained.

    again: RMS by which a latent differs that is encoded from what it was decoded to. white: how far the means of the
    whitened training latents are from 0, and a tenth of how far their covariance is from 1. principal: it consists of
    principal components, so it must rebuild its training shapes and vary as they do. heads: settings beyond the
    dimension for the model of 40 heads.
    """

    again: float
    white: float
    principal: bool = False
    heads: dict = field(default_factory=dict)


KINDS = {
    "pca": Tested(again=1e-9, white=1e-3, principal=True),
    # A sum of features is no shape's features; decoding makes the nearest one.
    "intrinsic": Tested(again=0.1, white=1e-3, principal=True),
    # Its training latents are of everyone and their mirror images, and projections, not yet the nearest shapes.
    "kernel": Tested(again=1e-6, white=0.03, principal=True, heads={"components": 30, "centres": 64}),
}
"""A new kind is one line here. Those that are trained otherwise have files of their own, see test_kinds.py."""

PRINCIPAL = [kind for kind, tested in KINDS.items() if tested.principal]


def trained(kind, template, shapes, **settings):
    """A model of a kind. settings: of its config; a dimension is left out where the config has none."""
    config = config_class(kind)
    if "dimension" not in {setting.name for setting in fields(config)}:
        settings.pop("dimension")
    return model_class(kind).train(template, shapes, config(**settings))


@pytest.fixture(scope="session")
def tested_kinds():
    return KINDS


@pytest.fixture(scope="session")
def of_heads(head_template, people):
    """A function that gives the model of a kind, trained once on 40 random heads."""
    return cache(lambda kind: trained(kind, head_template, people, dimension=DIMENSION, **KINDS[kind].heads))


@pytest.fixture(scope="session")
def pca(of_heads):
    return of_heads("pca")


@pytest.fixture(scope="session")
def intrinsic(of_heads):
    return of_heads("intrinsic")


@pytest.fixture(scope="session")
def kernel(of_heads):
    return of_heads("kernel")


@pytest.fixture(scope="session", params=KINDS)
def model(request, of_heads):
    """Each kind in turn, trained on 40 random heads."""
    return of_heads(request.param)


@pytest.fixture(scope="session", params=PRINCIPAL)
def principal_model(request, of_heads):
    """Each kind of principal components in turn, trained on 40 random heads."""
    return of_heads(request.param)


@pytest.fixture(scope="session")
def tested(model):
    """What is asked of the model."""
    return KINDS[model.kind]


@pytest.fixture(scope="session")
def ball_template(ball):
    """A template of 300 vertices with an annotation of its own, without UVs."""
    source = {"ibug68": list(range(0, 272, 4)), "regions": {"face": list(range(150))}}
    vertices, faces = ball
    return Template(vertices, faces, annotation=parse_annotation(source, len(vertices), "ball"))


@pytest.fixture(scope="session")
def balls(ball):
    """(30, 300, 3) smoothly bent balls, some of them away from the origin."""
    generator = np.random.default_rng(11)
    vertices = ball[0]
    waves = [np.sin(vertices @ generator.normal(size=(3, 3)) + generator.normal(size=3)) for _ in range(5)]
    weights = generator.normal(0, 0.15, (30, 5))
    return vertices + np.tensordot(weights, np.array(waves), 1) + 0.1 * weights[:, None, :3]


@pytest.fixture(scope="session", params=KINDS)
def train_balls(request, ball_template):
    """A function that trains each kind in turn, from shapes (N, 300, 3) and a dimension."""
    return lambda shapes, dimension: trained(request.param, ball_template, shapes, dimension=dimension)


@pytest.fixture(scope="session", params=PRINCIPAL)
def train_principal(request, ball_template):
    """``train_balls`` for each kind of principal components."""
    return lambda shapes, dimension: trained(request.param, ball_template, shapes, dimension=dimension)


@pytest.fixture(scope="session")
def ball_model(train_balls, balls):
    """Each kind in turn, small enough to be built in no time."""
    return train_balls(balls, 5)


@pytest.fixture(scope="session")
def ball_components(train_principal, balls):
    """``ball_model`` for each kind of principal components: its tensors have a mean and a basis."""
    return train_principal(balls, 5)
