import shutil

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.io.bundled import asset_path, config_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json, write_json
from caricli.methods.evaluate.evaluate_shape import evaluate_shape
from caricli.models.kinds import KINDS
from caricli.store.models import load_model

TRAINED = ["pca", "intrinsic", "kernel"]
"""Kinds of the fixture ``models``."""

BUNDLED = [kind for kind in KINDS if asset_path(f"{kind}.safetensors").is_file()]


@pytest.mark.parametrize("kind", TRAINED)
def test_a_model_is_written_that_rebuilds_itself_with_a_report(models, dataset, kind):
    model, report = load_model(models[kind]), read_json(models[kind].with_suffix(".json"))
    assert model.kind == kind and len(model.prior.mean) == 5
    assert report["command"] == f"train {kind}" and report["config"]["dimension"] == 5
    assert report["inputs"] == {str(dataset / "dataset.json"): sha256_file(dataset / "dataset.json")}
    assert report["model_id"] == model.model_id
    data = read_dataset(dataset)
    np.testing.assert_array_equal(model.template.polygons, data.template.polygons)
    error = evaluate_shape(model, data.vertices[data.rows("test")])
    assert report["shape_error"]["test"]["meshes"] == 4
    np.testing.assert_allclose(report["shape_error"]["test"]["millimetres"], error.millimetres, rtol=1e-6)
    assert 0 < report["shape_error"]["train"]["percent"] < report["shape_error"]["test"]["percent"] < 10


@pytest.mark.parametrize("kind", TRAINED)
def test_same_data_same_bytes(run, models, dataset, tmp_path, kind):
    out = tmp_path / "again.safetensors"
    assert run("train", kind, "--data", dataset, "--out", out, "--set", "dimension=5").exit_code == 0
    assert out.read_bytes() == models[kind].read_bytes()
    assert out.with_suffix(".json").read_bytes() == models[kind].with_suffix(".json").read_bytes()


def test_settings_come_from_a_file_and_from_the_line(run, dataset, tmp_path):
    tiny = config_path("pca/tiny.yaml")
    for name, options, dimension in (("a", [], 7), ("b", ["--set", "dimension=3"], 3)):
        out = tmp_path / f"{name}.safetensors"
        result = run("train", "pca", "--data", dataset, "--out", out, "--config", tiny, *options)
        assert result.exit_code == 0, result.output
        # Eight training meshes have seven components, whatever is asked for.
        assert len(load_model(out).prior.mean) == dimension


@pytest.mark.parametrize("kind", TRAINED)
def test_bad_input_is_one_line_and_leaves_nothing(refused, dataset, tmp_path, kind):
    out = tmp_path / "new" / "m.safetensors"

    def check(*words, data=dataset, target=out, options=(), code=1):
        said = refused("train", kind, "--data", data, "--out", target, *options, code=code)
        assert all(word in said for word in words), said

    check("missing", data=tmp_path / "missing")
    check(".safetensors", target=tmp_path / "m.pkl", code=2)
    check("dimensions", options=("--set", "dimensions=3"), code=2)
    check("dimension", options=("--set", "dimension=many"), code=2)
    check("dimension", options=("--set", "dimension=0"), code=2)
    check("none.yaml", options=("--config", tmp_path / "none.yaml"))
    bad = tmp_path / "bad.yaml"
    for content, word in (("dimension: !!python/object:os.system 3", "tag"), ("dim: 3", "dim"), ("- 3", "key: value")):
        bad.write_text(content)
        check(word, "bad.yaml", options=("--config", bad))
    assert [path.name for path in tmp_path.iterdir()] == ["bad.yaml"]


def test_what_exists_and_what_is_read_is_kept(refused, dataset, tmp_path):
    out = tmp_path / "m.safetensors"
    out.with_suffix(".json").write_text("mine")
    assert "m.json exists" in refused("train", "pca", "--data", dataset, "--out", out)
    assert out.with_suffix(".json").read_text() == "mine" and not out.exists()
    copy = shutil.copytree(dataset, tmp_path / "copy")
    before = (copy / "dataset.json").read_bytes()
    said = refused("train", "pca", "--data", copy, "--out", copy / "dataset.safetensors", "--overwrite")
    assert "dataset.json" in said and "input" in said
    assert (copy / "dataset.json").read_bytes() == before


def test_too_few_training_meshes_are_refused(refused, dataset, tmp_path):
    copy = shutil.copytree(dataset, tmp_path / "copy")
    splits = {"train": [], "validation": [0, 1], "test": [2, 3]}
    write_json(copy / "dataset.json", read_json(copy / "dataset.json") | {"splits": splits})
    for kind, out in (("pca", "m.safetensors"), ("deformable", "run")):
        said = refused("train", kind, "--data", copy, "--out", tmp_path / out)
        assert f"{copy}: expected at least 3 meshes in the dataset's train split, found 0" in said


def test_five_models_are_bundled():
    assert set(BUNDLED) >= {"pca", "intrinsic", "kernel", "deformable", "morphable"}


@pytest.mark.parametrize("kind", BUNDLED)
def test_the_bundled_models_are_small_and_come_with_recipe_and_error(kind):
    path = asset_path(f"{kind}.safetensors")
    assert path.stat().st_size <= 16e6
    assert load_model(kind=kind).kind == kind
    report = read_json(path.with_suffix(".json"))
    assert report["command"] == f"train {kind}" and report["model_id"] == load_model(path).model_id
    assert 0 < report["shape_error"]["test"]["percent"] < 5
    recipe = read_checkpoint(path)[1]["recipe"]
    for name in (*report["inputs"], *recipe["inputs"]):
        assert not name.startswith("/"), "a path of the machine it was trained on"
