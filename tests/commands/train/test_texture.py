import json
import shutil
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.commands.evaluate.texture import REGIONS, _print
from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.config import read_config
from caricli.io.image import read_image, write_png
from caricli.methods.dynamic.styles import StyleBook
from caricli.methods.evaluate.texture_rivals import train_reader
from caricli.methods.train.stages import unwatched
from caricli.models.texture.config import TextureConfig
from caricli.store.texture_run import TextureFolders, load_texture_ingredients, load_texture_test
from tests.acted_textures import write_acted_set

SETTINGS = ("epochs=2", "steps=2", "validate_every=1", "validation=6")
SMALL = ("--config", config_path("texture/tiny.yaml"), *(f"--set={text}" for text in SETTINGS))


@pytest.fixture(scope="module", autouse=True)
def little_learnt():
    """Few generated drawings, and rivals that have hardly learnt."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.store.styles.GENERATED", 3)
        patch.setattr("caricli.store.texture_run.train_reader", partial(train_reader, steps=20))
        patch.setattr("caricli.methods.evaluate.texture_rivals._PAIRS", 6)
        yield


@pytest.fixture(scope="module")
def textures(head, tmp_path_factory):
    return write_acted_set(tmp_path_factory.mktemp("acted") / "set", head)


@pytest.fixture(scope="module")
def trained(run, textures, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "run"
    result = run("train", "texture", "--data", textures, "--out", folder, *SMALL)
    assert result.exit_code == 0, result.output
    assert "epoch 2 of 2" in result.stderr and "of the texture kept" in result.stdout
    return folder


def test_what_it_writes(trained, textures):
    report = json.loads((trained / "model.json").read_text())
    assert report["command"] == "train texture" and report["config"]["epochs"] == 2
    assert list(report["inputs"]) == [str(textures / "textures.json")]
    assert report["validation"]["percent_of_kept"] > 0
    assert read_image(trained / "loss.png").std() > 0
    assert len((trained / "log.jsonl").read_text().splitlines()) == 2


def test_it_goes_on_to_the_same_bytes(run, trained, textures, tmp_path):
    folder = tmp_path / "run"
    first = run("train", "texture", "--data", textures, "--out", folder, *SMALL, "--resume")
    again = run("train", "texture", "--data", textures, "--out", folder, *SMALL, "--resume")
    assert first.exit_code == again.exit_code == 0
    assert (folder / "model.safetensors").read_bytes() == (trained / "model.safetensors").read_bytes()


def test_drawings_train_the_unpaired_part(run, textures, head, tmp_path):
    other = write_acted_set(tmp_path / "other", head)
    result = run("train", "texture", "--data", textures, "--drawings", other, "--out", tmp_path / "run", *SMALL)
    assert result.exit_code == 0, result.output
    assert len(json.loads((tmp_path / "run" / "model.json").read_text())["inputs"]) == 2


@pytest.mark.parametrize("setting", ["unpaired=0", "epochs=1"])
def test_drawings_without_an_unpaired_part_are_refused(refused, textures, tmp_path, setting):
    line = ("train", "texture", "--data", textures, "--drawings", textures, "--out", tmp_path / "run", *SMALL)
    assert "expected an unpaired part to train on it, found none" in refused(*line, "--set", setting)


@pytest.mark.parametrize(("split", "use"), [("train", "train"), ("validation", "validate")])
def test_a_folder_without_people_of_a_split_is_named(refused, textures, tmp_path, split, use):
    lacking = tmp_path / "lacking"
    shutil.copytree(textures, lacking)
    manifest = json.loads((lacking / "textures.json").read_text())
    manifest["splits"] |= {"test": manifest["splits"]["test"] + manifest["splits"][split], split: []}
    (lacking / "textures.json").write_text(json.dumps(manifest))
    out = ("--out", tmp_path / "run")
    words = f"lacking: expected people to {use} with, found none"
    assert words in refused("train", "texture", "--data", lacking, *out, *SMALL)
    if use == "train":
        assert words in refused("train", "texture", "--data", textures, "--drawings", lacking, *out, *SMALL)
    assert not (tmp_path / "run").exists()


def test_folders_with_other_numbers_of_expressions_are_refused(refused, textures, head, tmp_path):
    fewer = write_acted_set(tmp_path / "fewer", head, shown=3)
    line = ("train", "texture", "--data", textures, "--data", fewer, "--out", tmp_path / "run", *SMALL)
    assert f"fewer: expected 4 expressions of everybody, as in {textures}, found 3" in refused(*line)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("option", ["--data", "--drawings"])
def test_folders_that_share_people_between_splits_are_refused(refused, head, tmp_path, option):
    folders = [
        write_acted_set(tmp_path / split, head, people={split: "0123456789ab", "test": "cdef01234567"})
        for split in ("train", "validation")
    ]
    line = ("train", "texture", "--data", folders[1], option, folders[0], "--out", tmp_path / "run", *SMALL)
    assert f"{folders[1]}, {folders[0]}: expected datasets of different people, found 1 whom" in refused(*line)
    assert not (tmp_path / "run").exists()


def test_it_is_measured(run, trained, textures, tmp_path):
    network = trained / "model.safetensors"
    result = run("evaluate", "texture", network, "--data", textures, "--out", tmp_path / "out", "--count", "8")
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "out" / "texture.json").read_text())
    assert set(report["painters"]) == {"kept", "linear", "spline", str(network)}
    assert report["people"] == 2 and set(report["reading"]) == {"kept", "linear", "spline", "true", str(network)}
    assert set(report["flicker"]) == {"linear", "spline", str(network)} and report["flicker"]["linear"] < 1
    for region in ("attention", "outside", "mouth"):
        figure = report["painters"]["kept"][region]
        assert figure["percent"] == figure["low"] == figure["high"] == 100
    assert read_image(tmp_path / "out" / "texture.png").shape == (8 * 32, 5 * 32, 3)


class Noted(StyleBook):
    """Media, and what each was drawn with."""

    def __init__(self):
        super().__init__()
        self.seeds = set()

    def draw(self, generator):
        self.seeds.add(tuple(generator.bit_generator.seed_seq.entropy))
        return super().draw(generator)


def test_people_wear_other_styles_for_every_use(trained, textures):
    learning = Noted()
    settings = read_config(config_path("texture/tiny.yaml"), TextureConfig, ())
    load_texture_ingredients([textures], textures, settings, learning, unwatched)
    assert len(learning.seeds) == 4 + 4 + 2
    testing = Noted()
    load_texture_test([trained / "model.safetensors"], TextureFolders(textures), testing, settings.seed, unwatched)
    assert len(testing.seeds - learning.seeds) == 2 and len(testing.seeds) == 4 + 2


def test_what_no_face_shows_is_printed_as_not_measured(capsys):
    shown = {"error": 0.1, "percent": 100.0, "low": 99.0, "high": 101.0}
    kept = dict.fromkeys(REGIONS, shown) | {"mouth": dict.fromkeys(shown)}
    _print({"painters": {"kept": kept}, "reading": {"kept": 0.1, "true": 0.1}, "flicker": {}})
    row = next(line for line in capsys.readouterr().out.splitlines() if "kept  " in line)
    assert [cell.strip() for cell in row.split("│")[2:6]] == [
        "100 (99 to 101)",
        "100 (99 to 101)",
        "-",
        "100 (99 to 101)",
    ]


def test_everybody_of_another_folder_is_tested(textures, head, tmp_path):
    others = write_acted_set(tmp_path / "others", head, age=0.4, gender=0.9)
    learnt, tested = TextureFolders(textures, others).people()
    assert len(learnt) == 4 and {person.split for person in learnt} == {"train"}
    assert len(tested) == 8 and len(TextureFolders(textures).people()[1]) == 2
    assert np.ptp([person.neutral[0] for person in tested], axis=0).max() == 0
    assert np.abs(tested[0].neutral - learnt[0].neutral).max() > 1e-3


def test_whom_rivals_learn_from_is_not_tested(refused, trained, textures, tmp_path):
    network = trained / "model.safetensors"
    line = ("evaluate", "texture", network, "--data", textures, "--people", textures, "--out", tmp_path / "out")
    assert "expected people whom nobody learnt with, found 8" in refused(*line)


def test_what_is_no_folder_of_textures_is_refused(refused, trained, textures, tmp_path):
    def told(folder, out, *more):
        return refused("train", "texture", "--data", folder, "--out", out, *SMALL, *more)

    assert "textures.json" in told(tmp_path, tmp_path / "run")
    assert "--overwrite to begin anew" in told(textures, trained)
    assert "expected a folder of drawings" in told(textures, tmp_path / "run", "--styles", tmp_path / "none")
    assert "found one of the inputs" in told(textures, textures, "--overwrite")
    assert "at least 64 texels, found 32" in told(textures, tmp_path / "large", "--set", "size=64")


def test_a_broken_picture_among_styles_is_left_out_and_said(run, refused, textures, tmp_path):
    styles = tmp_path / "styles"
    styles.mkdir()
    (styles / "broken.png").write_bytes(b"\x89PNG no picture")
    line = ("train", "texture", "--data", textures, "--styles", styles, "--out", tmp_path / "run", *SMALL)
    assert "found no picture in it that can be read" in refused(*line)
    write_png(styles / "good.png", np.random.default_rng(0).integers(0, 255, (96, 96, 3), np.uint8))
    result = run(*line)
    assert result.exit_code == 0, result.output
    assert "left out: " in result.stderr and "broken.png" in result.stderr


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("topology_id", "0" * 64, "of the head's mesh, found one of another"),
        ("expressions", ["smile"], "of ARKit's 52 expressions, found one of others"),
    ],
)
def test_a_network_of_something_else_is_not_measured(refused, trained, textures, tmp_path, key, value, words):
    tensors, about = read_checkpoint(trained / "model.safetensors")
    write_checkpoint(tmp_path / "other.safetensors", tensors, about | {key: value})
    line = ("evaluate", "texture", tmp_path / "other.safetensors", "--data", textures, "--out", tmp_path / "out")
    said = refused(*line)
    assert "other.safetensors" in said and words in said
    assert not (tmp_path / "out").exists()


def test_whom_rivals_learn_from_is_not_tested_at_another_level(textures, head, tmp_path):
    others = write_acted_set(tmp_path / "others", head, gender=0.9)
    with pytest.raises(InputError, match="expected people whom nobody learnt with, found 4"):
        TextureFolders(textures, others).people()


def test_whom_the_network_learnt_from_is_not_tested(refused, trained, textures, head, tmp_path):
    others = write_acted_set(tmp_path / "others", head, age=0.4, gender=0.9)
    network = trained / "model.safetensors"
    line = ("evaluate", "texture", network, "--data", others, "--people", textures, "--out", tmp_path / "out")
    assert "expected people of no training, found what" in refused(*line)


def test_whom_a_network_has_seen_in_another_folder_is_not_tested(head, tmp_path):
    marks = {"train": "aaaaaaaaaaaa", "validation": "bbbbbbbbbbbb", "test": "cccccccccccc"}
    folder = write_acted_set(tmp_path / "marked", head, people=marks)
    strangers = write_acted_set(tmp_path / "strangers", head, people={"test": "dddddddddddd"})

    def learnt(seen, folders):
        network: Any = SimpleNamespace(recipe={"people": {"train": seen, "validation": ""}})
        return folders.learnt_by(network)

    assert not learnt("aaaaaaaaaaaa", TextureFolders(folder))
    assert learnt("cccccccccccc", TextureFolders(folder))
    assert learnt("aaaaaaaaaaaa", TextureFolders(strangers, folder))
    assert not learnt("aaaaaaaaaaaa", TextureFolders(folder, strangers))
