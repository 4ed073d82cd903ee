import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.data.picture_set import read_picture_set
from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.coarse.coarse_faces import JoinedFaces, StudiedFace, TrueFaces
from caricli.methods.train.coarse.train_coarse import CoarseTraining, Sources, new_coarse_network
from caricli.methods.train.processes import ALL, Share
from caricli.models.coarse.config import CoarseConfig
from caricli.models.coarse.model import SHARE
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.store.models import load_morphable
from caricli.structures.parsing import Region
from tests.posed_pictures import small_dataset, write_posed_set


class Unmarked:
    """Faces whose truth nobody tells."""

    def __init__(self, faces):
        self.source = faces
        self.faces = faces.faces

    def study(self, number):
        face = self.source.study(number)
        return StudiedFace(face.picture, face.frame, None)


@pytest.fixture(scope="module")
def model():
    return load_morphable()


@pytest.fixture(scope="module")
def detector():
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    return detector_of(network, 64)


@pytest.fixture(scope="module")
def sources(model, people, tmp_path_factory):
    dataset = small_dataset(model.template, people[:6])
    pictures = read_picture_set(write_posed_set(tmp_path_factory.mktemp("posed") / "set", dataset, 72, 4))
    training, unseen = (JoinedFaces([TrueFaces(pictures, dataset, model, split)]) for split in ("train", "validation"))
    return Sources(training, Unmarked(training), unseen)


def begin(sources, model, detector, *overrides, share=ALL):
    config = read_config(config_path("coarse/tiny.yaml"), CoarseConfig, overrides)
    return CoarseTraining(sources, model, detector, config, share)


def test_it_begins_with_the_mean_face_in_the_middle_and_learns(sources, model, detector):
    training = begin(sources, model, detector, "epochs=4", "steps=8", "rounds=2", "unmarked=1")
    face = sources.unseen.study(0)
    np.testing.assert_allclose(training.latent(training.average.eval(), face), 0, atol=1e-6)
    records = list(training.epochs())
    assert records[-1].loss < 0.8 * records[0].loss
    assert records[-1].train_error < records[0].train_error
    doubts = training.doubts(training.average)
    assert doubts.shape == (239,) and (doubts > 0).all() and (doubts[-15:] == 1).all()


def test_the_mean_face_from_the_front_is_where_its_window_has_it(model):
    config = read_config(config_path("coarse/tiny.yaml"), CoarseConfig)
    network = new_coarse_network(config, model, torch.Generator())
    flat = model.mean[:, :2] - model.mean[:, :2].mean(0)
    *_, x, y, scale = network.start.tolist()
    points = scale * flat[model.template.annotation.landmarks[:68]] * [1, -1] + [x, y]
    np.testing.assert_allclose((points + 0.5) / 64, network.usual[:68].numpy(), atol=1e-3)  # it is not quite upright
    assert np.ptp(points, axis=0).max() == pytest.approx(64 / SHARE, rel=1e-3)


@pytest.mark.parametrize("rounds", [1, 3])
def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(sources, model, detector, rounds):
    settings = (f"rounds={rounds}", "epochs=2")
    whole = begin(sources, model, detector, *settings)
    states = [copy.deepcopy(whole.state()) for _ in whole.epochs()]
    left = begin(sources, model, detector, *settings)
    left.load_state(states[0])
    list(left.epochs())
    for name, value in left.average.state_dict().items():
        assert torch.equal(value, whole.average.state_dict()[name]), name
    assert left.state()["counters"] == states[-1]["counters"]


def test_with_rounds_the_encoder_stays_and_windows_are_drawn_once(sources, model, detector):
    training = begin(sources, model, detector, "rounds=3", "epochs=1")
    before = copy.deepcopy(training.network.state_dict())
    drawn = []
    draw = training.drawer.draw

    def counted(face, plain, generator):
        drawn.append(face)
        return draw(face, plain, generator)

    training.drawer.draw = counted
    list(training.epochs())
    assert len(drawn) == 8
    for name, value in training.network.state_dict().items():
        if name.startswith(("stem.", "down.")):
            assert torch.equal(value, before[name]), name


def test_processes_share_the_windows_of_a_batch(sources, model, detector):
    whole = begin(sources, model, detector)._draw(0).windows
    parts = [begin(sources, model, detector, share=Share(process, 2))._draw(0).windows for process in (0, 1)]
    assert [window.truth is None for window in whole] == [True] * 2 + [False] * 6
    assert [window.plain for window in whole] == [True] * 4 + [False] * 4
    for number, window in enumerate(whole):
        np.testing.assert_array_equal(parts[number % 2][number // 2].picture.pixels, window.picture.pixels)


def test_every_process_needs_a_face_with_truth(sources, model, detector):
    for process in range(8):
        with pytest.raises(InputError, match="one for each of 8 processes, found 6 windows with truth"):
            begin(sources, model, detector, share=Share(process, 8))
    begin(replace(sources, unmarked=None), model, detector, share=Share(0, 8))


@pytest.mark.parametrize("unmarked", [0, 2])
def test_it_learns_without_painting_what_is_true(sources, model, detector, unmarked):
    (record,) = begin(sources, model, detector, "epochs=1", "painted=0", f"unmarked={unmarked}").epochs()
    assert np.isfinite([record.loss, record.train_error]).all()


def test_another_detector_or_no_face_is_refused(sources, model, detector):
    with pytest.raises(InputError, match="a detector for windows of 96 pixels, found one for 64"):
        begin(sources, model, detector, "size=96")
    sources_without = Sources(sources.true, None, type("None", (), {"faces": []})())
    with pytest.raises(InputError, match="faces to validate on"):
        begin(sources_without, model, detector)
