import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.methods.evaluate.reconstruct_portrait import NETWORK
from caricli.store.marked_folder import MarkedFolder
from caricli.store.portraits import load_portrait, load_rivals, portrait_files
from caricli.structures import Landmarks


@pytest.fixture
def folder(points, tmp_path):
    picture = np.full((400, 400, 3), 200, np.uint8)
    write_png(tmp_path / "one.png", picture)
    np.savetxt(tmp_path / "one.txt", points[:68])
    (tmp_path / "notes.md").write_text("not a picture")
    return tmp_path


@pytest.fixture
def points(head_template):
    marks = 1400 * head_template.vertices[head_template.annotation.landmarks] @ np.diag([1.0, -1, -1])[:, :2]
    return marks - marks.mean(0) + 200


def test_pictures_go_with_the_landmarks_of_their_name(folder, points):
    assert portrait_files(None) == []
    (pair,) = portrait_files(folder)
    assert [path.name for path in pair] == ["one.png", "one.txt"]
    portrait = load_portrait(*pair)
    assert portrait.name == "one.png" and portrait.image.shape == (400, 400, 3) and portrait.truth is None
    np.testing.assert_allclose(portrait.points, points[:68])


def test_portraits_come_in_the_order_of_their_names(folder):
    names = [f"{number}.png" for number in (7, 3, 9, 1, 5, 8, 2, 6, 4)]
    for name in names:
        for suffix in (".png", ".txt"):
            (folder / name).with_suffix(suffix).write_bytes((folder / "one").with_suffix(suffix).read_bytes())
    assert [picture.name for picture, _ in portrait_files(folder)] == [*sorted(names), "one.png"]


def test_of_several_landmark_files_all_take_the_same(folder, points):
    for suffix in (".npy", ".txt", ".pts", ".json"):
        write_landmarks(folder / f"one{suffix}", Landmarks(points[:68]))
        ((picture, marks),) = portrait_files(folder)
        assert marks == MarkedFolder.of(folder).file(picture)
    assert marks.suffix == ".json"
    marks.write_text('{"schema": "caricli.portrait/1"}')  # a report that has the picture's name
    ((picture, marks),) = portrait_files(folder)
    assert marks.suffix == ".pts" and marks == MarkedFolder.of(folder).file(picture)


def test_a_landmark_file_that_is_damaged_is_read_to_say_so(folder):
    (folder / "one.txt").write_text("1 2\nthree")
    ((_, marks),) = portrait_files(folder)
    assert marks.suffix == ".txt"


def test_the_first_pixel_of_a_pts_file_is_as_it_is_said(folder, points):
    rows = "\n".join(f"{x} {y}" for x, y in points[:68])
    (folder / "one.pts").write_text(f"version: 1\nn_points: 68\n{{\n{rows}\n}}\n")
    (folder / "one.txt").unlink()
    (pair,) = portrait_files(folder)
    offset = load_portrait(*pair, pts_origin=0).points - load_portrait(*pair, pts_origin=1).points
    np.testing.assert_allclose(offset, 1)


def test_folders_without_portraits_are_refused(folder, tmp_path):
    with pytest.raises(InputError, match="missing: expected a folder of pictures"):
        portrait_files(tmp_path / "missing")
    (tmp_path / "bare").mkdir()
    with pytest.raises(InputError, match="bare: expected pictures"):
        portrait_files(tmp_path / "bare")
    (folder / "one.txt").unlink()
    with pytest.raises(InputError, match=r"one\.png: expected landmarks beside it"):
        portrait_files(folder)


def test_rivals_are_of_the_mesh_of_the_dataset(head_template):
    rivals = load_rivals(head_template)
    assert rivals.pop(NETWORK).basis == rivals["morphable"].model_id
    assert {kind: model.kind for kind, model in rivals.items()} == {
        kind: kind for kind in ("morphable", "intrinsic", "deformable")
    }
