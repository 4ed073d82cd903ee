import shutil

import pytest

from caricli.io.bundled import config_path
from caricli.io.image import read_image
from caricli.io.strict_json import read_json, write_json
from caricli.methods.evaluate.evaluate_ablation import LINEAR, NETWORKS

TINY = ("--config", config_path("ablation/tiny.yaml"))


@pytest.fixture(scope="module")
def ablation(run, dataset, tmp_path_factory):
    out = tmp_path_factory.mktemp("ablation") / "new" / "ablation"
    result = run("evaluate", "ablation", "--data", dataset, "--out", out, *TINY, "--set", "unseen=2")
    assert result.exit_code == 0, result.output
    return out, result.stdout


def test_figure_and_table_are_written(ablation):
    out, printed = ablation
    assert sorted(path.name for path in out.iterdir()) == ["ablation.json", "ablation.md", "ablation.png"]
    found = read_json(out / "ablation.json")
    assert found["command"] == "evaluate ablation" and len(found["inputs"]) == 1
    assert found["config"]["epochs"] == 4 and found["meshes"] == 8 and found["unseen"] == 2
    assert [model["name"] for model in found["models"]] == [*NETWORKS, *LINEAR]
    picture = read_image(out / "ablation.png")
    assert picture.shape[1] > 2 * picture.shape[0] and picture.std() > 10
    lines = (out / "ablation.md").read_text().splitlines()
    assert len(lines) == 2 + len(found["models"])
    for model, line in zip(found["models"], lines[2:], strict=True):
        cells = [
            model["name"],
            f"{model['parameters']:,}",
            *(f"{model[key]:.3f}" for key in ("train", "test", "surface")),
        ]
        assert line.startswith(f"| {' | '.join(cells)} | ")
        assert line.endswith(" | 0 |" if model["name"] in NETWORKS else " | - |")
        assert all(cell in printed for cell in cells)


def test_several_seeds_give_means_and_spreads(run, ablation, dataset, tmp_path):
    out = tmp_path / "ablation"
    settings = ("--set", "unseen=2", "--set", "latent_weight=2e5", "--set", "seed=7", "--seeds", "0, 3")
    result = run("evaluate", "ablation", "--data", dataset, "--out", out, *TINY, *settings)
    assert result.exit_code == 0, result.output
    lines = (out / "ablation.md").read_text().splitlines()[2:]
    models = read_json(out / "ablation.json")["models"]
    alone = read_json(ablation[0] / "ablation.json")["models"]
    assert "spread" not in alone[0] and "seeds" not in alone[0]
    for model, line, other in zip(models, lines, alone, strict=True):
        assert [own["seed"] for own in model["seeds"]] == [0, 3]
        for name in ("train", "test", "surface"):
            first, second = (own[name] for own in model["seeds"])
            assert model[name] == pytest.approx((first + second) / 2)
            assert model["spread"][name] == pytest.approx(abs(first - second) / 2**0.5)
            assert f" {model[name]:.3f} ± {model['spread'][name]:.3f} " in line
        network = model["name"] in NETWORKS
        assert model["spread"]["train"] > 0 or not network
        # Of the same seed, only without the latents' weight: it counts for every network, and for nothing else.
        assert (model["seeds"][0]["train"] != other["train"]) == network
        assert line.endswith(" | 200000 |" if network else " | - |")


def test_a_folder_is_replaced_only_when_it_is_one_of_these(run, refused, ablation, dataset, tmp_path):
    out = shutil.copytree(ablation[0], tmp_path / "ablation")
    again = ("evaluate", "ablation", "--data", dataset, "--out", out, *TINY, "--set", "unseen=1")
    assert "exists" in refused(*again)
    assert run(*again, "--overwrite").exit_code == 0
    assert read_json(out / "ablation.json")["unseen"] == 1
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("mine")
    said = refused("evaluate", "ablation", "--data", dataset, "--out", tmp_path / "mine", *TINY, "--overwrite")
    assert "ablation.json" in said and (tmp_path / "mine" / "thesis.txt").exists()


def test_bad_input_is_one_line_and_leaves_nothing(refused, dataset, tmp_path):
    out = ("--out", tmp_path / "new" / "ablation")
    assert "missing" in refused("evaluate", "ablation", "--data", tmp_path / "missing", *out)
    for setting in ("epochs=0", "network=siren", "meshes=-1"):
        said = refused("evaluate", "ablation", "--data", dataset, *out, "--set", setting, code=2)
        assert setting.split("=")[0] in said
    for seeds in ("0,0", "0,", "1;2", "-1", "4294967296", "9" * 5000, "٣", ""):
        said = refused("evaluate", "ablation", "--data", dataset, *out, "--seeds", seeds, code=2)
        assert "--seeds" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("split", "count"), [("train", 3), ("test", 1)])
def test_a_dataset_without_the_split_is_refused(refused, dataset, tmp_path, split, count):
    copy = shutil.copytree(dataset, tmp_path / "copy")
    splits = {"train": [0, 1], "validation": [2], "test": [3]} | {split: []}
    splits["validation"] = sorted({0, 1, 2, 3} - {*splits["train"], *splits["test"]})
    write_json(copy / "dataset.json", read_json(copy / "dataset.json") | {"splits": splits})
    said = refused("evaluate", "ablation", "--data", copy, "--out", tmp_path / "ablation", *TINY)
    assert f"{copy}: expected at least {count} meshes in the dataset's {split} split, found 0" in said


def test_cuda_is_refused_where_there_is_none(refused, dataset, tmp_path, monkeypatch):
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    said = refused("evaluate", "ablation", "--data", dataset, "--out", tmp_path / "ablation", "--device", "cuda")
    assert "CUDA" in said
