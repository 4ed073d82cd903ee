"""One small model of every kind."""

import numpy as np
import pytest

from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.kernel.model import KernelModel
from caricli.models.pca.model import PcaModel
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

DIMENSION = 12


@pytest.fixture(scope="session")
def pca(head_template, people):
    return PcaModel.train(head_template, people, DIMENSION)


@pytest.fixture(scope="session")
def intrinsic(head_template, people):
    return IntrinsicModel.train(head_template, people, DIMENSION)


@pytest.fixture(scope="session")
def kernel(head_template, people):
    return KernelModel.train(head_template, people, DIMENSION, components=30, centres=64)


@pytest.fixture(scope="session", params=["pca", "intrinsic", "kernel"])
def model(request):
    """Each kind in turn, trained on 40 random heads."""
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="session")
def ball_template(ball):
    """A template of 300 vertices with an annotation of its own, without UVs."""
    source = {"ibug68": list(range(0, 272, 4)), "regions": {"face": list(range(150))}}
    vertices, faces = ball
    return Template(vertices, faces, faces, parse_annotation(source, len(vertices), "ball"))


@pytest.fixture(scope="session")
def balls(ball):
    """(30, 300, 3) smoothly bent balls, some of them away from the origin."""
    generator = np.random.default_rng(11)
    vertices = ball[0]
    waves = [np.sin(vertices @ generator.normal(size=(3, 3)) + generator.normal(size=3)) for _ in range(5)]
    weights = generator.normal(0, 0.15, (30, 5))
    return vertices + np.tensordot(weights, np.array(waves), 1) + 0.1 * weights[:, None, :3]


@pytest.fixture(scope="session", params=[PcaModel, IntrinsicModel, KernelModel], ids=["pca", "intrinsic", "kernel"])
def ball_model(request, ball_template, balls):
    """Each kind in turn, small enough to be built in no time."""
    return request.param.train(ball_template, balls, 5)
