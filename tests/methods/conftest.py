"""The bundled models, and faces of which everything is known."""

from dataclasses import dataclass

import numpy as np
import pytest

from caricli.data.identities import random_identity
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.lines.slide_contour import slide_contour
from caricli.structures import Camera

FRONT = np.diag([1.0, -1.0, -1.0])


@pytest.fixture(scope="session")
def intrinsic():
    from caricli.store.models import load_model

    return load_model(kind="intrinsic")


@pytest.fixture(scope="session")
def pca():
    from caricli.store.models import load_model

    return load_model(kind="pca")


@pytest.fixture(scope="session")
def kernel():
    from caricli.store.models import load_model

    return load_model(kind="kernel")


@dataclass(frozen=True)
class Truth:
    """A face, the camera that saw it, and its 68 or 81 landmarks in pixels."""

    vertices: np.ndarray
    camera: Camera
    points: np.ndarray


@pytest.fixture(scope="session")
def seen(intrinsic):
    """A function: vertices, angles in degrees and number of landmarks to a Truth; the jaw is seen on the outline."""

    def make(vertices, pitch=0.0, yaw=0.0, roll=0.0, count=68):
        turns = np.radians([[pitch, 0, 0], [0, yaw, 0], [0, 0, roll]])
        matrices = rotation_matrices(turns)
        rotation = matrices[2] @ matrices[0] @ matrices[1] @ FRONT
        camera = Camera(1500.0, rotation, np.array([310.0, 540.0]))
        note = intrinsic.template.annotation
        jaw = slide_contour(vertices, rotation, intrinsic.template.vertices, note.landmarks[:17], note.jaw_paths)
        return Truth(vertices, camera, camera.project(vertices[np.r_[jaw, note.landmarks[17:count]]]))

    return make


@pytest.fixture(scope="session")
def strangers(head):
    """Six people whom no model was trained on, some of them with an expression."""
    generator = np.random.default_rng(2024)
    acting = [{}, {"mouthSmileLeft": 0.7, "mouthSmileRight": 0.7}, {"jawOpen": 0.4}, {}, {"browInnerUp": 0.8}, {}]
    return [head.evaluate(**vars(random_identity(head, generator)), actions=actions) for actions in acting]
