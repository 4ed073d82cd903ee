import pytest
from threadpoolctl import threadpool_limits

from caricli.io.bundled import config_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.strict_json import read_json

TINY = ("--config", config_path("landmark_map/tiny.yaml"))


@pytest.fixture(scope="module")
def trained(run, dataset, tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.safetensors"
    result = run("train", "landmark-map", "--data", dataset, "--out", path, *TINY, "--seed", 3)
    assert result.exit_code == 0, result.output
    assert f"{path}: error to normal " in result.stdout and ", to caricature " in result.stdout
    return path


def test_a_map_is_written_with_a_report(trained, run, marks, tmp_path):
    report, (tensors, metadata) = read_json(trained.with_suffix(".json")), read_checkpoint(trained)
    assert report["command"] == "train landmark-map" and report["seed"] == 3 and report["config"]["styles"] == 1
    assert metadata["schema"] == "caricli.landmark-map/2" and len(tensors["styles"]) == 1
    assert report["meshes"]["training"] == {"normal": 4, "caricature": 4}
    for to in ("normal", "caricature"):
        errors = report["error"]["test"][to]
        assert {"map", "identity", "mean", "paired regression"} <= set(errors)
        assert errors["identity"]["below_identity"] == 0 < errors["map"]["error"]
    assert metadata["recipe"]["people"] == report["people"] and report["people"]["train"]
    result = run("map-landmarks", marks, "--to", "normal", "--out", tmp_path / "m.json", "--map", trained)
    assert result.exit_code == 0, result.output


def test_the_same_seed_gives_the_same_bytes(trained, run, dataset, tmp_path):
    again = tmp_path / "again.safetensors"
    run("train", "landmark-map", "--data", dataset, "--out", again, *TINY, "--seed", 3)
    assert again.read_bytes() == trained.read_bytes()


def test_the_number_of_threads_changes_no_figure(run, dataset, tmp_path):
    reports = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            run("train", "landmark-map", "--data", dataset, "--out", tmp_path / f"{threads}.safetensors", *TINY)
        reports.append(read_json(tmp_path / f"{threads}.json"))
    assert reports[0]["error"] == reports[1]["error"]


def test_a_dataset_without_both_domains_is_refused(run, refused, tmp_path):
    folder, out = tmp_path / "regular", tmp_path / "out" / "map.safetensors"
    sizes = ("--identities", 4, "--expressions", 2, "--levels", 1, "--workers", 1)
    assert run("dataset", "build", folder, *sizes).exit_code == 0
    line = refused("train", "landmark-map", "--data", folder, "--out", out, *TINY)
    assert str(folder) in line and "caricature faces, found 0" in line
    assert not out.parent.exists()


@pytest.mark.parametrize("setting", ["styles=0", "views=0", "noise=-1", "no_such=1"])
def test_impossible_settings_are_refused(refused, dataset, tmp_path, setting):
    out = tmp_path / "map.safetensors"
    line = refused("train", "landmark-map", "--data", dataset, "--out", out, "--set", setting, code=2)
    assert setting.split("=")[0] in line and not out.exists()
