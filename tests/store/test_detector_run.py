from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
import torch

from caricli.data.picture_set import read_picture_set
from caricli.data.unseen import training_entry
from caricli.errors import InputError
from caricli.io.bundled import asset_path, config_path
from caricli.io.config import read_config
from caricli.io.strict_json import read_json
from caricli.methods.train.processes import ALL
from caricli.models.detector.config import DetectorConfig
from caricli.models.detector.networks import network_of
from caricli.store.detector import load_detector
from caricli.store.detector_run import DetectorRun, drawing_ahead, load_training
from caricli.store.training_run import FILES, MODEL, Beginning
from tests.drawn_pictures import mean_shape, write_drawn_set

SETTINGS = ("epochs=3", "steps=2", "batch=6", "validate_every=1", "validation=4")


@pytest.fixture(scope="module")
def pictures(head_template, tmp_path_factory):
    return write_drawn_set(tmp_path_factory.mktemp("drawn") / "set", mean_shape(head_template), 16, 0)


def begin(pictures, folder, resume=False, start=None):
    config = read_config(config_path("detector/tiny.yaml"), DetectorConfig, SETTINGS)
    recipe = {"config": asdict(config), "inputs": {"pictures.json": "0" * 64}}
    return DetectorRun(folder, recipe, Beginning(resume=resume)), load_training([pictures], config, ALL, "cpu", start)


def test_a_run_that_was_left_goes_on_to_the_same_bytes(pictures, tmp_path):
    whole, training = begin(pictures, tmp_path / "whole")
    assert [line["epoch"] for line in whole.follow(training)] == [1, 2, 3]
    on_the_way = (tmp_path / "whole" / MODEL).stat().st_size
    figures = whole.finish(training)
    # Half precision stays; trust, jaw and up to twenty axes of 136 numbers of usual shapes are added.
    assert (tmp_path / "whole" / MODEL).stat().st_size < on_the_way + 2000 + 20 * 136 * 4
    assert sorted(path.name for path in (tmp_path / "whole").iterdir()) == sorted(FILES)
    left, training = begin(pictures, tmp_path / "left")
    for line in left.follow(training):
        if line["epoch"] == 2:
            break
    for _ in range(2):  # the second time there is nothing left to do but to measure
        again, training = begin(pictures, tmp_path / "left", resume=True)
        list(again.follow(training))
        again.finish(training)
        assert (tmp_path / "left" / MODEL).read_bytes() == (tmp_path / "whole" / MODEL).read_bytes()
    report = read_json(tmp_path / "whole" / "model.json")
    detector = load_detector(tmp_path / "whole" / MODEL)
    assert report["model_id"] == detector.model_id and report["trust"] == detector.calibration.trust
    assert report["validation"] == figures and report["epochs"] == 3
    assert detector.recipe["inputs"] == {"pictures.json": "0" * 64}


def test_folders_that_share_people_between_splits_are_refused(head_template, pictures, tmp_path):
    shape = mean_shape(head_template)
    folders = [
        write_drawn_set(tmp_path / split, shape, 8, 0, people={split: "0123456789ab"}) for split in ("train", "test")
    ]
    with pytest.raises(InputError, match="/test: expected datasets of different people, found 1 whom"):
        training_entry([read_picture_set(folder) for folder in folders])
    # Of people of an older folder nobody can tell.
    one = read_picture_set(folders[0])
    assert training_entry([read_picture_set(pictures), one]) == {}
    assert training_entry([one]) == {"people": {"train": "0123456789ab", "validation": ""}}


def test_what_a_gpu_learns_from_other_processes_draw_alike(pictures, tmp_path, monkeypatch):
    monkeypatch.setattr("caricli.store.detector_run.usable_cores", lambda: 4)
    _, training = begin(pictures, tmp_path / "run")
    training.device = "cuda"
    with drawing_ahead(training, [pictures]):
        drawn = training._ahead.draw(0, 0)
    assert np.array_equal(drawn.pixels, training.windows.draw(0, 0).pixels)


def test_a_training_begins_with_the_weights_of_another(pictures, tmp_path):
    run, training = begin(pictures, tmp_path / "first")
    list(run.follow(training))
    first = network_of(load_detector(tmp_path / "first" / MODEL))
    _, further = begin(pictures, tmp_path / "further", start=tmp_path / "first" / MODEL)
    for own in (further.network, further.average):
        for name, value in own.state_dict().items():
            assert not value.is_floating_point() or torch.equal(value, first.state_dict()[name]), name
    config = read_config(config_path("detector/tiny.yaml"), DetectorConfig, [*SETTINGS, "width=8"])
    with pytest.raises(InputError, match="expected a detector of DetectorSize"):
        load_training([pictures], config, ALL, "cpu", tmp_path / "first" / MODEL)


def test_what_is_bundled_says_how_it_was_made_and_is_small():
    file = asset_path("detector.safetensors")
    assert file.stat().st_size < 6e6
    report = read_json(asset_path("detector.json"))
    detector = load_detector()
    assert report["model_id"] == detector.model_id and report["config"] == detector.recipe["config"]
    assert not any(Path(name).is_absolute() for name in detector.recipe["inputs"])
