import shutil

import numpy as np
import pytest

from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.strict_json import read_json, write_json
from caricli.methods.evaluate.evaluate_portrait import RENDERED, PortraitTally
from caricli.methods.evaluate.portrait_studio import PortraitStudio
from caricli.methods.evaluate.reconstruct_portrait import COARSE, METHODS, NETWORK, REFINED
from caricli.structures import Landmarks

COMMAND = "evaluate", "portrait"


@pytest.fixture(scope="module", autouse=True)
def small():
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"SIZE": 96, "TEXTURE": 64, "VIEW": 48}.items():
            patch.setattr(f"caricli.commands.evaluate.portrait.{name}", value)
        yield


@pytest.fixture(scope="module")
def pictures(head, head_template, tmp_path_factory):
    """A folder with a picture and its landmarks."""
    folder = tmp_path_factory.mktemp("pictures")
    vertices = head.evaluate(gender=0.2, age=0.8)
    portrait = PortraitStudio(head_template, 160).portray("one", vertices, np.random.default_rng(1))
    write_png(folder / "one.png", portrait.image)
    write_landmarks(folder / "one.txt", Landmarks(portrait.points))
    (folder / "notes.md").write_text("not a picture")
    return folder


@pytest.fixture(scope="module")
def evaluated(run, dataset, pictures, tmp_path_factory):
    out = tmp_path_factory.mktemp("evaluated") / "new" / "portraits"
    result = run(*COMMAND, "--data", dataset, "--out", out, "--count", 2, "--pictures", pictures)
    assert result.exit_code == 0, result.output
    return out, result.stdout


def test_tables_figures_and_picture_are_written(evaluated):
    out, printed = evaluated
    assert sorted(path.name for path in out.iterdir()) == ["portrait.json", "portrait.png"]
    found = read_json(out / "portrait.json")
    assert found["command"] == "evaluate portrait" and found["seed"] == 0 and found["noise"] == 0.3
    assert len(found["inputs"]) == 3 and found["models"].keys() == {*COARSE.values(), NETWORK}
    assert len(found["faces"]["rendered"]) == 2 and list(found["faces"]["pictures"]) == ["one.png"]
    assert "2 rendered" in printed and "1 pictures" in printed
    for name, rivals in found["means"].items():
        faces = found["faces"][name].values()
        assert tuple(rivals) == METHODS
        for method, row in rivals.items():
            assert ("shape" in row) == (name == "rendered")
            assert ("photometric" in row) == (not method.startswith("adjust"))
            assert row["nme"]["all"] == pytest.approx(np.mean([face[method]["nme"]["all"] for face in faces]))
            lines = [line for line in printed.splitlines() if line.split("│")[1:2] == [f" {method:20} "]]
            assert len(lines) == 2 and any(f" {row['nme']['eyes']:.2f} " in line for line in lines)
        for method in COARSE:
            # The elastic fit may be as near as that by itself.
            assert rivals[method + REFINED]["nme"]["all"] < max(0.15, rivals[method]["nme"]["all"] / 3)
            assert 0 < rivals[method + REFINED]["photometric"] < 10
    for method, gain in found["refinement"].items():
        assert gain["faces"] == 2 and f"3D error of {method} from {gain['before']:.3f} to" in printed
    picture = read_image(out / "portrait.png")
    assert picture.shape[1] > 6 * 48 and picture.shape[0] > 3 * 48 and picture.std() > 10


def test_everybody_can_be_portrayed(run, dataset, monkeypatch, tmp_path):
    portrayed = []

    def evaluate(sets, models):
        portrayed.extend(sets[RENDERED].data.identity[sets[RENDERED].rows])
        return PortraitTally(figures={RENDERED: {}}), np.zeros((4, 4, 3), np.uint8)

    monkeypatch.setattr("caricli.commands.evaluate.portrait._evaluate", evaluate)
    result = run(*COMMAND, "--data", dataset, "--out", tmp_path / "a", "--count", 16, "--everyone")
    assert result.exit_code == 0, result.output
    assert read_json(tmp_path / "a" / "portrait.json")["test_people"] == {"unseen": 4, "of": 4}
    assert sorted(portrayed) == sorted(4 * [0, 1, 2, 3])


@pytest.mark.slow
def test_everybody_is_portrayed_from_beginning_to_end(run, dataset, tmp_path):
    assert run(*COMMAND, "--data", dataset, "--out", tmp_path / "a", "--count", 1, "--everyone").exit_code == 0
    assert read_json(tmp_path / "a" / "portrait.json")["test_people"] == {"unseen": 4, "of": 4}


def test_the_same_seed_gives_the_same_figures(evaluated, from_one):
    ((name, face),) = read_json(from_one / "portrait.json")["faces"]["rendered"].items()
    before = read_json(evaluated[0] / "portrait.json")["faces"]["rendered"]
    for method, figures in face.items():
        timeless = {key: value for key, value in before[name][method].items() if key != "seconds"}
        assert {key: value for key, value in figures.items() if key != "seconds"} == timeless


def test_bad_input_is_one_line_and_leaves_nothing(refused, dataset, pictures, tmp_path):
    given = ("--data", dataset, "--out", tmp_path / "new" / "out")
    assert "missing" in refused(*COMMAND, "--data", tmp_path / "missing", *given[2:])
    assert "folder of pictures" in refused(*COMMAND, *given, "--pictures", tmp_path / "missing")
    bare = tmp_path / "bare"
    bare.mkdir()
    assert "expected pictures" in refused(*COMMAND, *given, "--pictures", bare)
    shutil.copy(pictures / "one.png", bare / "two.png")
    said = refused(*COMMAND, *given, "--pictures", bare)
    assert "two.png" in said and "landmarks" in said
    (bare / "two.txt").write_text("1 2\n")
    assert "two.txt" in refused(*COMMAND, *given, "--pictures", bare)
    assert [path.name for path in tmp_path.iterdir()] == ["bare"]


def test_a_dataset_without_test_meshes_is_refused(refused, dataset, tmp_path):
    copy = shutil.copytree(dataset, tmp_path / "copy")
    splits = {"train": [0, 1, 2], "validation": [3], "test": []}
    write_json(copy / "dataset.json", read_json(copy / "dataset.json") | {"splits": splits})
    said = refused(*COMMAND, "--data", copy, "--out", tmp_path / "out")
    assert "test split" in said and not (tmp_path / "out").exists()


def test_a_dataset_of_other_meshes_is_refused(run, refused, eggs, tmp_path):
    data = tmp_path / "eggs"
    assert run("dataset", "import", eggs, data, "--annotation", eggs.parent / "annotation.json").exit_code == 0
    said = refused(*COMMAND, "--data", data, "--out", tmp_path / "out")
    assert "topology" in said and not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def from_one(run, dataset, pictures, tmp_path_factory):
    """The same evaluation of a face less, with landmarks that are counted from 1."""
    folder = tmp_path_factory.mktemp("from-1")
    shutil.copy(pictures / "one.png", folder)
    rows = "\n".join(f"{x:.6f} {y:.6f}" for x, y in np.loadtxt(pictures / "one.txt") + 1)
    (folder / "one.pts").write_text(f"version: 1\nn_points: 68\n{{\n{rows}\n}}\n")
    options = ("--count", 1, "--pictures", folder, "--pts-origin", 1)
    result = run(*COMMAND, "--data", dataset, "--out", folder / "out", *options)
    assert result.exit_code == 0, result.output
    return folder / "out"


def test_the_first_pixel_of_a_pts_file_is_as_it_is_said(evaluated, from_one):
    faces = [read_json(out / "portrait.json")["faces"]["pictures"] for out in (from_one, evaluated[0])]
    for method, figures in faces[0]["one.png"].items():
        assert figures["nme"] == pytest.approx(faces[1]["one.png"][method]["nme"], abs=1e-3)


@pytest.mark.parametrize("option", [("--count", 0), ("--noise", "nan"), ("--noise", -1)])
def test_options_out_of_range_are_wrong_usage(run, dataset, tmp_path, option):
    assert run(*COMMAND, "--data", dataset, "--out", tmp_path / "out", *option).exit_code == 2
