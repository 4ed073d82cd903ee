import shutil

import pytest

from caricli.io.image import read_image


def test_prints_what_is_in_it_and_draws_a_sheet(run, dataset, tmp_path):
    result = run("dataset", "show", dataset, "-o", tmp_path / "sheet.png", "--faces", 3, "--size", 64)
    assert result.exit_code == 0, result.output
    assert "meshes 16, people 4, vertices 4200, faces 8356" in result.stdout
    assert "split by identity: train 8, validation 4, test 4" in result.stdout
    assert "kinds: regular 8, curvature 8, parts 0, curvature and parts 0" in result.stdout
    assert "components for 99 % of the variance: " in result.stdout
    sheet = read_image(tmp_path / "sheet.png")
    assert min(sheet.shape[:2]) >= 64 and sheet.std() > 10


def test_a_sheet_is_not_needed_and_the_seed_chooses_its_faces(run, dataset, tmp_path):
    assert "meshes 16" in run("dataset", "show", dataset).stdout
    for name, seed in (("a.png", 0), ("b.png", 0), ("c.png", 1)):
        arguments = ("-o", tmp_path / name, "--faces", 2, "--size", 32, "--seed", seed)
        assert run("dataset", "show", dataset, *arguments).exit_code == 0
    a, b, c = ((tmp_path / name).read_bytes() for name in ("a.png", "b.png", "c.png"))
    assert a == b != c


def test_bad_input_is_one_line(refused, dataset, tmp_path):
    assert "missing" in refused("dataset", "show", tmp_path / "missing", "-o", tmp_path / "x.png")
    (tmp_path / "empty").mkdir()
    assert "no dataset.json" in refused("dataset", "show", tmp_path / "empty", "-o", tmp_path / "x.png")
    copy = shutil.copytree(dataset, tmp_path / "copy")
    with open(copy / "shard-0000.npz", "ab") as stream:
        stream.write(b"more")
    assert "shard-0000.npz" in refused("dataset", "show", copy, "-o", tmp_path / "x.png")
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize("name", ["dataset.json", "shard-0000.npz", "labels.npz", "template.npz"])
def test_the_sheet_does_not_replace_the_dataset(refused, dataset, name):
    before = (dataset / name).read_bytes()
    assert "ends in .png" in refused("dataset", "show", dataset, "-o", dataset / name, "--overwrite", code=2)
    assert (dataset / name).read_bytes() == before
