import numpy as np
import pytest

from caricli.io.face import write_face
from caricli.io.image import read_image
from caricli.io.strict_json import read_json, write_json
from caricli.methods.evaluate.evaluate_blendshapes import RIVALS
from caricli.structures import Camera, Face

pytestmark = pytest.mark.usefixtures("quick_pictures")

COMMAND = "evaluate", "blendshapes"


@pytest.fixture(scope="module")
def small():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.commands.evaluate.blendshapes.SIZE", 48)
        patch.setattr("caricli.commands.evaluate.blendshapes.SHOWN", ("smile",))
        yield


@pytest.fixture(scope="module")
def evaluated(run, dataset, small, quick_pictures, tmp_path_factory):
    out = tmp_path_factory.mktemp("evaluated") / "new" / "expressions"
    result = run(*COMMAND, "--data", dataset, "--everyone", "--count", 3, "--out", out)
    assert result.exit_code == 0, result.output
    return out, result.stdout


def test_tables_figures_and_picture_are_written(evaluated):
    out, printed = evaluated
    assert sorted(path.name for path in out.iterdir()) == ["blendshapes.json", "blendshapes.png"]
    found = read_json(out / "blendshapes.json")
    assert found["command"] == "evaluate blendshapes" and found["given"] == "neutral" and found["seed"] == 0
    assert "3 caricatures" in printed and len(found["caricatures"]) == 3
    assert tuple(found["means"]) == ("truth", *RIVALS) and found["means"]["truth"]["error"] == 0
    for name, row in found["means"].items():
        each = [one["rivals"][name]["error"]["smile"] for one in found["caricatures"]]
        assert row["error"] == pytest.approx(np.mean(each)) and f" {row['error']:.3f} " in printed
    smile = found["expressions"]["smile"]
    assert smile["of"] == 3 and 0 <= smile["full_is_nearest_on"] <= 3
    assert smile["beside_transfer"]["low"] <= smile["beside_transfer"]["mean"] <= smile["beside_transfer"]["high"]
    off = found["means"]["truth"]
    assert off["drift_off"] == off["strength_off"] == 0 < found["means"]["full"]["drift_off"]
    # The given expression is no expression to make.
    assert found["expressions"]["neutral"]["of"] == 0
    assert len({one["person"] for one in found["caricatures"]}) >= 2
    rows, cells = 1 + len(RIVALS), 2
    picture = read_image(out / "blendshapes.png")
    assert picture.shape[0] >= rows * 48 and cells * 48 <= picture.shape[1] < 4 * 48


def test_any_expression_may_be_given(run, dataset, small, tmp_path):
    assert run(*COMMAND, "--data", dataset, "--everyone", "--given", "any", "--out", tmp_path / "a").exit_code == 0
    found = read_json(tmp_path / "a" / "blendshapes.json")
    counts = [found["expressions"][name]["of"] for name in ("neutral", "smile")]
    assert sum(counts) == len(found["caricatures"]) == 4 and counts[0] > 0


def test_faces_of_one_name_are_drawn_all(run, dataset, small, head_template, monkeypatch, tmp_path):
    paths = [tmp_path / folder / "face.npz" for folder in ("first", "second")]
    camera = Camera(1000.0, np.diag([1.0, -1, -1]), np.array([200.0, 300]))
    for path in paths:
        path.parent.mkdir()
        write_face(
            path,
            Face(head_template, camera, camera.project(head_template.vertices[head_template.annotation.landmarks])),
        )
    drawn = []
    sheet = "caricli.methods.evaluate.blendshape_sheet.BlendshapeSheet.add_face"
    monkeypatch.setattr(sheet, lambda self, name, face, pictures: drawn.append(name))
    options = ("--everyone", "--count", 1, "--face", paths[0], "--face", paths[1], "--out", tmp_path / "out")
    assert run(*COMMAND, "--data", dataset, *options).exit_code == 0
    assert drawn == ["first", "second"]


def test_without_caricatures_there_is_nothing_to_evaluate(refused, run, dataset, tmp_path):
    sizes = ("--identities", 2, "--expressions", 2, "--levels", 1)
    assert run("dataset", "build", tmp_path / "calm", *sizes, "--seed", 5).exit_code == 0
    said = refused(*COMMAND, "--data", tmp_path / "calm", "--everyone", "--out", tmp_path / "out")
    assert "calm: expected caricatures with every expression, found none; build one without --count" in said
    assert "dataset.json" in refused(*COMMAND, "--data", tmp_path, "--out", tmp_path / "out")
    manifest = read_json(dataset / "dataset.json")
    other = tmp_path / "other"
    other.mkdir()
    for path in dataset.iterdir():
        (other / path.name).symlink_to(path) if path.suffix == ".npz" else None
    write_json(other / "dataset.json", manifest | {"expressions": ["neutral", "grimace"]})
    assert "other: expected a dataset of caricli dataset build" in refused(
        *COMMAND, "--data", other, "--out", tmp_path / "out"
    )
    assert not (tmp_path / "out").exists()


def test_people_of_the_default_seed_were_trained_with(refused, run, tmp_path):
    sizes = ("--identities", 2, "--expressions", 2, "--levels", 1)
    assert run("dataset", "build", tmp_path / "calm", *sizes).exit_code == 0
    data = ("--data", tmp_path / "calm")
    said = refused(*COMMAND, *data, "--everyone", "--out", tmp_path / "out")
    assert "calm: expected test people unseen in the training of morphable and kernel and landmark map, found" in said
    assert "kernel" in refused("evaluate", "shape", "kernel", *data)
    assert "unseen in the training of" in refused("evaluate", "portrait", *data, "--out", tmp_path / "out")
