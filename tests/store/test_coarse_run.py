from dataclasses import asdict

import numpy as np
import pytest
import torch

from caricli.data.picture_set import read_picture_set
from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.io.image import write_png
from caricli.io.strict_json import read_json
from caricli.methods.train.coarse.coarse_faces import JoinedFaces, TrueFaces
from caricli.methods.train.coarse.train_coarse import CoarseTraining, Sources
from caricli.models.coarse.config import CoarseConfig
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.store.coarse import load_coarse, load_coarse_pair
from caricli.store.coarse_run import CoarseRun, PictureFolders, see_faces
from caricli.store.models import load_morphable
from caricli.store.training_run import FILES, MODEL, Beginning
from caricli.structures.parsing import Region
from tests.posed_pictures import small_dataset, write_posed_set

SETTINGS = ("epochs=3", "steps=2", "batch=4", "painted=1", "unmarked=0", "validation=2")


@pytest.fixture(scope="module")
def detector():
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    return detector_of(network, 64)


@pytest.fixture(scope="module")
def folder(head_template, people, tmp_path_factory):
    dataset = small_dataset(head_template, people[:6])
    return write_posed_set(tmp_path_factory.mktemp("posed") / "set", dataset, 72, 4), dataset


def begin(pictures, detector, folder, resume=False):
    config = read_config(config_path("coarse/tiny.yaml"), CoarseConfig, SETTINGS)
    recipe = {"config": asdict(config), "inputs": {"pictures.json": "0" * 64}}
    model = load_morphable()
    marked = read_picture_set(pictures[0])
    training, unseen = (
        JoinedFaces([TrueFaces(marked, pictures[1], model, split)]) for split in ("train", "validation")
    )
    run = CoarseRun(folder, recipe, Beginning(resume=resume))
    return run, CoarseTraining(Sources(training, None, unseen), model, detector, config)


def test_a_run_that_was_left_goes_on_to_the_same_bytes(folder, detector, tmp_path):
    whole, training = begin(folder, detector, tmp_path / "whole")
    assert [line["epoch"] for line in whole.follow(training)] == [1, 2, 3]
    figures = whole.finish(training)
    assert sorted(path.name for path in (tmp_path / "whole").iterdir()) == sorted(FILES)
    left, training = begin(folder, detector, tmp_path / "left")
    for line in left.follow(training):
        if line["epoch"] == 2:
            break
    for _ in range(2):  # the second time there is nothing left to do but to measure
        again, training = begin(folder, detector, tmp_path / "left", resume=True)
        list(again.follow(training))
        again.finish(training)
        assert (tmp_path / "left" / MODEL).read_bytes() == (tmp_path / "whole" / MODEL).read_bytes()
    network = load_coarse(tmp_path / "whole" / MODEL)
    report = read_json(tmp_path / "whole" / "model.json")
    assert report["model_id"] == network.model_id == figures["model_id"] and report["epochs"] == 3
    assert network.basis == load_morphable().model_id and (network.doubt[:144] != 1).all()


def test_folders_are_told_apart_by_what_is_in_them(folder, tmp_path):
    plain = tmp_path / "plain"
    plain.mkdir()
    write_png(plain / "b.png", np.zeros((8, 8, 3), np.uint8))
    (plain / "notes.txt").write_text("none")
    folders = PictureFolders.of([plain, folder[0]])
    assert folders.marked == [folder[0]] and folders.plain == [plain]
    assert [path.name for path in folders.files] == ["b.png"]
    before = folders.inputs()
    write_png(plain / "a.png", np.zeros((8, 8, 3), np.uint8))
    after = folders.inputs()
    assert before.keys() == after.keys() and before[str(plain)] != after[str(plain)]
    with pytest.raises(InputError, match="found none"):
        PictureFolders.of([plain])
    with pytest.raises(InputError, match="expected a folder"):
        PictureFolders.of([plain / "a.png"])


def test_pictures_without_a_face_are_counted(detector, tmp_path):
    write_png(tmp_path / "empty.png", np.zeros((32, 32, 3), np.uint8))
    (tmp_path / "broken.png").write_bytes(b"none")
    seen = see_faces([tmp_path / "empty.png", tmp_path / "broken.png"], detector)
    assert not seen.faces and len(seen.unseen) == 2


def test_a_network_for_another_morphable_model_is_refused(folder, detector, tmp_path):
    from caricli.io.checkpoint import write_checkpoint
    from caricli.models.coarse.model import CoarseModel, coarse_to_checkpoint

    _, training = begin(folder, detector, tmp_path / "run")
    file = tmp_path / "other.safetensors"
    write_checkpoint(file, *coarse_to_checkpoint(CoarseModel(training.copied_average(), 64, "other")))
    with pytest.raises(InputError, match="expected a network for the morphable model"):
        load_coarse_pair(file)
