import numpy as np
import pytest

from caricli.data.exaggerate_parts import exaggerate_parts
from caricli.data.move_parts import NAMES, move_parts, random_hand, random_part_changes
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel

NO_HAND = np.zeros((81, 3))


@pytest.fixture(scope="module")
def model(head_template, people):
    return IntrinsicModel.train(head_template, people[:30], IntrinsicConfig(16))


@pytest.mark.parametrize("seed", range(4))
def test_landmarks_reach_their_targets_within_millimetres(model, people, seed):
    generator = np.random.default_rng(seed)
    face, landmarks = people[30 + seed], model.template.annotation.landmarks
    changes = random_part_changes(generator)
    hand = random_hand(face[landmarks], generator)
    target = move_parts(face[landmarks], changes) + hand
    moved = exaggerate_parts(face, changes, hand, model)
    before = np.linalg.norm(target - face[landmarks], axis=1)
    after = np.linalg.norm(target - moved[landmarks], axis=1)
    assert before.mean() > 0.003
    assert after.mean() < 0.0015 and after.max() < 0.006
    assert after.mean() < 0.3 * before.mean()


def test_no_change_leaves_the_face(model, people):
    moved = exaggerate_parts(people[35], np.zeros(len(NAMES)), NO_HAND, model)
    assert np.abs(moved - people[35]).max() < 1e-5


def test_the_input_stays_as_it_is(model, people):
    face = people[36].copy()
    exaggerate_parts(face, random_part_changes(np.random.default_rng(1)), NO_HAND, model)
    np.testing.assert_array_equal(face, people[36])


def test_a_change_of_the_nose_brings_its_surroundings_and_leaves_the_skull(model, people):
    changes = np.array([0.3 if name == "nose_size" else 0.0 for name in NAMES])
    face, template = people[37], model.template
    moved = np.linalg.norm(exaggerate_parts(face, changes, NO_HAND, model) - face, axis=1)
    nose = template.region("nose")
    assert moved[nose].max() > 0.005
    assert moved[template.region("scalp")].mean() < 0.2 * moved[nose].mean()
    # A spike would be a vertex that goes much further than everything around it.
    faces = template.faces
    corners, others = faces.ravel(), np.roll(faces, 1, axis=1).ravel()
    around = np.bincount(corners, moved[others]) / np.bincount(corners)
    assert (moved - around).max() < 0.25 * moved.max()
