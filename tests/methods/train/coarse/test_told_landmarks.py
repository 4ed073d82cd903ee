import numpy as np
import pytest
import torch

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.read_faces import read_face
from caricli.methods.train.coarse.coarse_faces import CoarseWindow, TrueFace
from caricli.methods.train.coarse.told_landmarks import FaceMixer, Seer, ToldSettings, cut_landmarks, hand_marked
from caricli.models.detector.calibration import Calibration
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.store.models import load_morphable
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.parsing import Region


def test_it_sees_what_readers_of_pictures_see():
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    torch.nn.init.normal_(network.heat.weight, std=3.0, generator=torch.Generator().manual_seed(1))
    detector = detector_of(network, 64)
    detector.calibration = Calibration(1.5)
    generator = np.random.default_rng(0)
    picture = generator.integers(0, 256, (64, 64, 3), np.uint8)
    # A frame whose window is the picture.
    read = read_face(picture, FaceFrame(np.array([31.5, 31.5]), 40.0, 0.0), 1.6, detector)
    seen = Seer(detector).see(torch.from_numpy(picture / np.float32(255)).permute(2, 0, 1)[None])[0][0].numpy()
    there = np.isfinite(seen).all(1)
    assert there.any()
    np.testing.assert_allclose(64 * seen[there, :2] - 0.5, space_jaw(read.points)[there], atol=1e-3)
    covariances = np.stack([read.spreads[:, 0, 0], read.spreads[:, 1, 1], read.spreads[:, 0, 1]], 1)
    np.testing.assert_allclose(64**2 * seen[there, 2:], covariances[there], atol=1e-3, rtol=1e-4)


def test_faces_that_nobody_drew_stand_where_the_window_has_its_face():
    model = load_morphable()
    template = model.template
    face = model.mean[template.region("face")]
    shapes = np.stack([model.mean, model.mean]).astype(np.float32)
    rotation = rotation_matrices(np.array([[0.1, 0.2, 0.0]]))[0] @ np.diag([1.0, -1, -1])
    truth = TrueFace(shapes[0], shapes[0], np.array(template.annotation.landmarks), rotation)
    marks = 30 * (model.mean[truth.anchors] @ rotation.T)[:, :2] / 0.1 + [60, 50]
    marked = MarkedPicture(np.zeros((128, 128, 3)), np.zeros((128, 128)), marks[None], np.ones((1, 81), bool))
    drawn = FaceMixer(shapes, template, face).draw(CoarseWindow(marked, truth, True), np.random.default_rng(0))
    # Mixed of people who are all one, it is that one.
    np.testing.assert_allclose(drawn.truth.vertices, shapes[0], atol=1e-6)
    np.testing.assert_allclose(drawn.truth.rotation, rotation, atol=1e-6)
    np.testing.assert_allclose(drawn.points[17:68], marks[17:68], atol=1.5)
    other = np.stack([shapes[0], 1.2 * shapes[0] * np.array([1, 1.1, 1], np.float32)])
    several = [
        FaceMixer(other, template, face)
        .draw(CoarseWindow(marked, truth, True), np.random.default_rng(k))
        .truth.vertices
        for k in range(4)
    ]
    assert max(np.abs(each - several[0]).max() for each in several) > 1e-3


def test_some_landmarks_are_as_people_mark_them_and_some_end_at_a_line():
    generator = np.random.default_rng(0)
    points = generator.uniform(10, 50, (81, 2))
    settings = ToldSettings()
    marked = [hand_marked(points, 64, generator) for _ in range(600)]
    given = [each for each in marked if each is not None]
    assert len(given) / 600 == pytest.approx(settings.marked, abs=0.05)
    assert np.std([each[:68] - points[:68] for each in given]) == pytest.approx(64 * settings.slip, rel=0.05)
    assert 0.3 < np.mean([np.isnan(each[68:]).all() for each in given]) < 0.7
    cuts = [cut_landmarks(points, generator) for _ in range(600)]
    assert np.mean([not each.all() for each in cuts]) == pytest.approx(settings.cut, abs=0.05)
    assert min(each.mean() for each in cuts) >= 1 - settings.most - 0.02
