"""One small model of every kind."""

import numpy as np
import pytest

from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.kernel.config import KernelConfig
from caricli.models.kernel.model import KernelModel
from caricli.models.kinds import config_class, model_class
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

DIMENSION = 12


@pytest.fixture(scope="session")
def pca(head_template, people):
    return PcaModel.train(head_template, people, PcaConfig(DIMENSION))


@pytest.fixture(scope="session")
def intrinsic(head_template, people):
    return IntrinsicModel.train(head_template, people, IntrinsicConfig(DIMENSION))


@pytest.fixture(scope="session")
def kernel(head_template, people):
    return KernelModel.train(head_template, people, KernelConfig(DIMENSION, components=30, centres=64))


@pytest.fixture(scope="session", params=["pca", "intrinsic", "kernel"])
def model(request):
    """Each kind in turn, trained on 40 random heads."""
    return request.getfixturevalue(request.param)


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


@pytest.fixture(scope="session", params=["pca", "intrinsic", "kernel"])
def train_balls(request, ball_template):
    """A function that trains each kind in turn, from shapes (N, 300, 3) and a dimension."""

    def train(shapes, dimension):
        return model_class(request.param).train(ball_template, shapes, config_class(request.param)(dimension))

    return train


@pytest.fixture(scope="session")
def ball_model(train_balls, balls):
    """Each kind in turn, small enough to be built in no time."""
    return train_balls(balls, 5)
