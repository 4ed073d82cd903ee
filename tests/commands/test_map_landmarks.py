import numpy as np
import pytest

from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.image import read_image
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.structures import Landmarks

BUNDLED = asset_path("landmark_map.safetensors")


def test_landmarks_are_mapped_and_drawn(run, marks, tmp_path):
    out = tmp_path / "new" / "normal.json"
    result = run("map-landmarks", marks, "--to", "normal", "--out", out)
    assert result.exit_code == 0, result.output
    assert f"{out}: 68 landmarks to normal, moved by " in result.stdout
    given, mapped = read_landmarks(marks), read_landmarks(out)
    assert mapped.image_size == given.image_size and mapped.points.shape == (68, 2)
    moved = np.linalg.norm(mapped.points - given.points, axis=1).mean() / np.linalg.norm(np.ptp(given.points, axis=0))
    assert 0 < moved < 0.1
    picture = read_image(out.with_suffix(".png"))
    blue, red = ((picture[..., k] > picture[..., 2 - k].astype(int) + 100).nonzero()[1].mean() for k in (2, 0))
    assert red < blue, "the given caricature is on the left"


def test_of_81_landmarks_the_first_68_are_mapped(run, points, marks, tmp_path):
    write_landmarks(tmp_path / "81.txt", Landmarks(points))
    result = run("map-landmarks", tmp_path / "81.txt", "--to", "caricature", "--out", tmp_path / "a.json")
    assert "68 landmarks (the first of 81)" in result.stdout
    run("map-landmarks", marks, "--to", "caricature", "--out", tmp_path / "b.json", "--map", BUNDLED)
    assert len(read_landmarks(tmp_path / "b.json").points) == 68
    np.testing.assert_array_equal(*(read_landmarks(tmp_path / name).points for name in ("a.json", "b.json")))


def test_seeds_draw_caricatures_of_one_face(run, marks, tmp_path):
    def mapped(name, *options):
        out = tmp_path / f"{name}.json"
        result = run("map-landmarks", marks, "--to", "caricature", "--out", out, *options)
        assert result.exit_code == 0, result.output
        return read_landmarks(out).points

    likeliest, first = mapped("likeliest"), mapped("first", "--style-seed", 1)
    np.testing.assert_array_equal(mapped("again", "--style-seed", 1), first)
    size = np.linalg.norm(np.ptp(likeliest, axis=0))
    drawn = [first, *(mapped(f"{seed}", "--style-seed", seed) for seed in (2, 3))]
    for one, other in ((likeliest, drawn[0]), drawn[:2], drawn[1:]):
        assert 0.002 < np.linalg.norm(one - other, axis=1).mean() / size < 0.2


def test_a_normal_face_has_no_style(refused, marks, tmp_path):
    out = tmp_path / "out" / "mapped.json"
    line = refused("map-landmarks", marks, "--to", "normal", "--style-seed", 1, "--out", out, code=2)
    assert "--style-seed is for --to caricature" in line and not out.parent.exists()


@pytest.mark.parametrize("name", ["unknown", "few", "scattered", "scheme", "truncated", "model"])
def test_bad_input_is_refused(refused, points, marks, tmp_path, name):
    landmarks, path, expected = marks, tmp_path / "map.safetensors", str(tmp_path / "map.safetensors")
    tensors, metadata = read_checkpoint(BUNDLED)
    if name in ("unknown", "few"):
        landmarks, path, expected = tmp_path / "bad.txt", BUNDLED, str(tmp_path / "bad.txt")
        bad = points[:68].copy()
        bad[3] = np.nan
        rows = bad if name == "unknown" else points[:20]
        landmarks.write_text("".join("null null\n" if np.isnan(x) else f"{x} {y}\n" for x, y in rows))
    elif name == "scattered":
        landmarks, path, expected = (
            tmp_path / "bad.txt",
            BUNDLED,
            f"{tmp_path / 'bad.txt'}: expected the landmarks of a",
        )
        np.savetxt(landmarks, np.random.default_rng(1).uniform(-1e6, 1e6, (68, 2)))
    elif name == "scheme":
        write_checkpoint(path, tensors, metadata | {"scheme": "wflw98"})
    elif name == "truncated":
        path.write_bytes(BUNDLED.read_bytes()[:-100])
    else:
        path = asset_path("pca.safetensors")
        expected = str(path)
    out = tmp_path / "out" / "mapped.json"
    assert expected in refused("map-landmarks", landmarks, "--to", "normal", "--out", out, "--map", path)
    assert not out.parent.exists()


def test_another_suffix_is_refused_though_the_file_is_there(refused, marks, tmp_path):
    out = tmp_path / "mapped.foo"
    out.write_text("mine")
    line = refused("map-landmarks", marks, "--to", "normal", "--out", out, "--overwrite", code=2)
    assert f"{out}: expected a name that ends in .json" in line
    assert out.read_text() == "mine"
