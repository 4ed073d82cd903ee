"""Lines of a head that no model has seen."""

import pytest

from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.line_handles import LineHandles
from caricli.store.models import load_model
from caricli.template.feature_curves import feature_curves


@pytest.fixture(scope="package")
def model():
    return load_model(kind="pca")


@pytest.fixture(scope="package")
def handles(model):
    return LineHandles(feature_curves(model.template.annotation))


@pytest.fixture(scope="package")
def person(head):
    """Vertices of somebody with an expression and large features."""
    changes = {"mouthSmileLeft": 0.6, "mouthSmileRight": 0.6, "jawOpen": 0.3}
    return head.evaluate(gender=0.1, age=0.8, actions=changes)


@pytest.fixture(scope="package")
def camera(person, handles):
    return canvas_camera(person, handles.curves)


@pytest.fixture(scope="package")
def sketch(person, handles, camera):
    return draw_sketch(person, handles.curves, camera)
