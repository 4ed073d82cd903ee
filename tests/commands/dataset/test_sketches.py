import shutil

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.data.sketch_set import picture_name, read_sketch_set
from caricli.io.image import read_image
from caricli.methods.sketch.draw_sketch import draw_curves
from caricli.structures import Camera, StrokeKind
from caricli.template.feature_curves import feature_curves
from tests.named_lines import points_by_curve

COUNT = 12


@pytest.fixture(scope="module")
def folder(run, dataset, tmp_path_factory):
    out = tmp_path_factory.mktemp("sketches") / "sketches"
    result = run("dataset", "sketches", dataset, out, "--count", COUNT, "--seed", 3, "--workers", 2)
    assert result.exit_code == 0, result.output
    return out


def test_the_same_seed_gives_the_same_bytes_whatever_the_number_of_workers(run, dataset, folder, tmp_path):
    again = tmp_path / "again"
    options = ("--count", COUNT, "--seed", 3, "--workers", 1)
    assert run("dataset", "sketches", dataset, again, *options).exit_code == 0
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(files) == COUNT + 2
    assert all((folder / file).read_bytes() == (again / file).read_bytes() for file in files)


@pytest.mark.parametrize("what", ["pictures", "sketches", "textures"])
def test_a_folder_that_holds_the_dataset_is_not_replaced(refused, dataset, tmp_path, what):
    out = tmp_path / "out"
    shutil.copytree(dataset, out / "people")
    (out / f"{what}.json").write_text("{}")
    said = refused("dataset", what, out / "people", out, "--count", 1, "--workers", 1, "--overwrite")
    assert f"found a folder that holds the input {out / 'people'}" in said
    assert (out / "people" / "dataset.json").exists()


def test_exact_lines_are_where_the_camera_sees_them(run, dataset, tmp_path):
    out = tmp_path / "exact"
    result = run("dataset", "sketches", dataset, out, "--count", 4, "--hand", 0, "--workers", 1)
    assert result.exit_code == 0, result.output
    people = read_dataset(dataset)
    curves = feature_curves(people.template.annotation)
    drawn = read_sketch_set(out)
    for number, sketch in enumerate(drawn.sketches(0)):
        camera = Camera(*(drawn.truth[key][number] for key in ("scale", "rotation", "translation")))
        row = drawn.truth["row"][number]
        assert drawn.truth["person"][number] == people.identity[row]
        named = points_by_curve(sketch)
        for stroke in draw_curves(people.vertices[row], curves, camera):
            assert np.allclose(named[stroke.curve], stroke.points, atol=1e-2)
        assert any(stroke.kind == StrokeKind.WRINKLE for stroke in sketch.strokes)


def test_what_hands_drew(folder):
    drawn = read_sketch_set(folder)
    sketches = drawn.sketches(0)
    assert len(sketches) == COUNT and drawn.side == 256
    pictures = [read_image(folder / picture_name(number)) for number in range(COUNT)]
    for sketch, picture in zip(sketches, pictures, strict=True):
        inked = (picture[..., 0] < 200).mean()
        assert picture.shape == (256, 256, 3) and 0.003 < inked < 0.3
        points = np.concatenate([stroke.points for stroke in sketch.strokes])
        assert ((points > -40) & (points < 296)).all()
    assert len({len(sketch.strokes) for sketch in sketches}) > 3
    assert sum(len(drawn.rows_of(split)) for split in ("train", "validation", "test")) == COUNT


def test_a_changed_file_is_refused(folder, tmp_path):
    import shutil

    from caricli.errors import InputError

    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    with open(copy / "strokes-0000.npz", "ab") as stream:
        stream.write(b"x")
    with pytest.raises(InputError, match="the file was changed"):
        read_sketch_set(copy)
