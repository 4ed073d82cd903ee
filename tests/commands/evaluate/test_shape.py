import shutil

import pytest

from caricli.io.strict_json import read_json


def test_models_stand_side_by_side(run, models, dataset, tmp_path):
    result = run("evaluate", "shape", *models.values(), "--data", dataset, "-o", tmp_path / "errors.json")
    assert result.exit_code == 0, result.output
    found = read_json(tmp_path / "errors.json")
    assert found["command"] == "evaluate shape" and len(found["inputs"]) == len(models) + 1
    for kind, path in models.items():
        errors = read_json(path.with_suffix(".json"))["shape_error"]
        assert found["models"][str(path)] == errors
        line = next(line for line in result.stdout.splitlines() if path.name in line)
        assert kind in line and f"{errors['test']['millimetres']:.3f} ({errors['test']['percent']:.3f})" in line
    again = run("evaluate", "shape", models["pca"], "--data", dataset)
    assert again.exit_code == 0 and "pca.safetensors" in again.stdout


def test_a_few_meshes_of_every_split_are_enough(run, models, dataset, tmp_path):
    out = tmp_path / "errors.json"
    result = run("evaluate", "shape", models["pca"], "--data", dataset, "--count", 3, "-o", out)
    assert result.exit_code == 0, result.output
    (found,) = read_json(out)["models"].values()
    assert {split: error["meshes"] for split, error in found.items()} == dict(train=3, validation=3, test=3)


def test_everybody_but_those_a_model_was_trained_with_can_be_tested_with(run, models, dataset, tmp_path):
    def measured(*models):
        out = tmp_path / f"{len(models)}.json"
        result = run("evaluate", "shape", *models, "--data", dataset, "--everyone", "-o", out)
        assert result.exit_code == 0, result.output
        found = read_json(out)
        assert all(set(errors) == {"test"} for errors in found["models"].values())
        return found["test_people"], {errors["test"]["meshes"] for errors in found["models"].values()}

    assert measured("pca") == ({"unseen": 4, "of": 4}, {16})
    people, meshes = measured("pca", models["pca"])
    assert people["unseen"] < people["of"] == 4 and meshes == {4 * people["unseen"]}


def test_bad_input_is_one_line_and_leaves_nothing(refused, models, dataset, tmp_path):
    out = ("-o", tmp_path / "errors.json")
    bad = tmp_path / "bad.safetensors"
    assert "bad.safetensors" in refused("evaluate", "shape", models["pca"], bad, "--data", dataset, *out)
    bad.write_bytes(b"\x80\x04\x95\x05\x00\x00\x00\x00\x00\x00\x00]\x94.")
    assert "pickle" in refused("evaluate", "shape", models["pca"], bad, "--data", dataset, *out)
    assert "missing" in refused("evaluate", "shape", models["pca"], "--data", tmp_path / "missing", *out)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.safetensors"]


@pytest.mark.parametrize("name", ["dataset.json", "shard-0000.npz"])
def test_figures_replace_neither_model_nor_dataset(refused, models, dataset, tmp_path, name):
    model, copy = shutil.copy(models["pca"], tmp_path / "m.safetensors"), shutil.copytree(dataset, tmp_path / "copy")
    for path in (model, copy / name):
        before = path.read_bytes()
        said = refused("evaluate", "shape", model, "--data", copy, "-o", path, "--overwrite")
        assert path.name in said and "input" in said
        assert path.read_bytes() == before


def test_a_model_and_a_dataset_are_needed(run, models, dataset):
    assert run("evaluate", "shape", models["pca"]).exit_code == 2
    assert run("evaluate", "shape", "--data", dataset).exit_code == 2
