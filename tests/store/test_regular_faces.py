import numpy as np
import pytest

from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.landmarks import write_landmarks
from caricli.store.models import load_model
from caricli.store.regular_faces import landmark_loader
from caricli.structures import Landmarks

SURE = np.tile(4 * np.eye(2), (81, 1, 1))


@pytest.fixture
def marks(head, head_template):
    """81 landmarks of a head from the front, found with the same doubt everywhere."""
    seen = 1400 * head.evaluate(gender=0.2)[head_template.annotation.landmarks] * [1, -1, 1]
    return Landmarks(seen[:, :2] - seen[:, :2].mean(0) + [200.0, 210.0], (400, 400), SURE)


def test_landmarks_are_followed_as_surely_as_they_are_known(marks, tmp_path):
    points, spreads = marks.points.copy(), SURE.copy()
    points[30] += [25, 0]
    spreads[30] *= 1e4
    load = landmark_loader(load_model(kind="pca"), 1, 64)
    heads = []
    for name, own in (
        ("true", marks),
        ("doubted", Landmarks(points, (400, 400), spreads)),
        ("sure", Landmarks(points)),
    ):
        write_landmarks(tmp_path / f"{name}.json", own)
        heads.append(load(tmp_path / f"{name}.json", None).face.vertices)
    doubted, sure = (np.linalg.norm(each - heads[0], axis=1).max() for each in heads[1:])
    assert doubted < 0.2 * sure


def test_of_found_landmarks_those_beyond_the_models_are_left_out(marks, tmp_path):
    tensors, about = read_checkpoint(asset_path("pca.safetensors"))
    about["annotation"] = {name: ids for name, ids in about["annotation"].items() if name != "extra13"}
    write_checkpoint(tmp_path / "few.safetensors", tensors, about)
    load = landmark_loader(load_model(tmp_path / "few.safetensors"), 1, 64)
    faces = []
    for name, own in (("many", marks), ("few", marks.first(68))):
        write_landmarks(tmp_path / f"{name}.json", own)
        faces.append(load(tmp_path / f"{name}.json", None).face)
    assert faces[0].landmarks.shape == (68, 2)
    np.testing.assert_array_equal(faces[0].vertices, faces[1].vertices)
