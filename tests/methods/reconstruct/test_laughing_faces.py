"""Open jaws from landmarks: what these do not show follows as it does in faces."""

import numpy as np
import pytest

from caricli.data.expressions import expand_sides
from caricli.data.identities import random_identity
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.reconstruct.fit_landmarks_intrinsic import fit_landmarks_intrinsic

LAUGH = {"jawOpen": 1.3, "mouthSmile": 0.9, "cheekSquint": 0.6, "mouthUpperUp": 0.5, "mouthLowerDown": 0.5}


@pytest.fixture(scope="module")
def laughing(head, seen):
    """Four people whom no model was trained on, with an expression that no model was trained on."""
    generator = np.random.default_rng(77)
    actions = expand_sides(LAUGH, head.action_names)
    people = [random_identity(head, generator) for _ in range(4)]
    return [seen(head.evaluate(**vars(one), actions=actions), 4 * k, 6 * k) for k, one in enumerate(people)]


def test_cheeks_chin_and_neck_follow_an_open_jaw(laughing, intrinsic):
    template = intrinsic.template
    face = template.region("face")
    regions = (template.mask("cheek_left", "cheek_right"), template.mask("chin"), template.mask("neck"))
    errors = []
    for truth in laughing:
        fit = fit_landmarks_intrinsic(truth.points, intrinsic)
        assert fit.nme < 0.1
        scale, rotation, translation = similarity(fit.face.vertices[face], truth.vertices[face])
        depth = (scale * fit.face.vertices @ rotation.T + translation - truth.vertices)[:, 2]
        errors.append([np.abs(depth[region]).mean() for region in regions])
    assert (np.mean(errors, axis=0) < [0.0032, 0.0038, 0.0105]).all()


def test_a_chin_far_below_takes_the_neck_along(laughing, intrinsic):
    points = laughing[0].points.copy()
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    points[3:14, 1] += 0.2 * diagonal * np.sin(np.linspace(0, np.pi, 11))
    neck = intrinsic.template.neck
    fit = fit_landmarks_intrinsic(points, intrinsic)
    assert fit.face.vertices[neck.front, 1] < fit.face.vertices[neck.chin, 1]
    assert fit.flipped < 5e-3
