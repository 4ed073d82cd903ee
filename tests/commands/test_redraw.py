"""`caricli retarget --picture`: pictures and films that are drawn again."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from skimage.data import astronaut

from caricli.io.image import read_alpha, read_image, write_png
from caricli.io.meshes.obj import write_obj
from caricli.io.parsing import legend, read_parsing, write_parsing
from caricli.io.rig import read_rig, write_rig
from caricli.io.strict_json import read_json, write_json
from caricli.store.models import load_model
from caricli.structures import Depiction, Mesh
from caricli.structures.parsing import Region
from tests.methods.redraw.conftest import CAMERA, stage  # noqa: F401
from tests.painted_moods import write_brightener

COMMAND = "retarget"
WEIGHTS = ({}, {"jawOpen": 0.8}, {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0})


@pytest.fixture(scope="module")
def sitting(stage, head, tmp_path_factory):  # noqa: F811
    """Rig NPZ, picture, label map, and three OBJ of a normal face: calm, its mouth open, smiling."""
    folder = tmp_path_factory.mktemp("sitting")
    names = ("jawOpen", "mouthSmileLeft", "mouthSmileRight")
    rows = [stage.rig.names.index(name) for name in names]
    normal = head.actions[[head.action_names.index(name) for name in names]].astype(np.float32)
    depiction = Depiction(CAMERA, stage.rig.neutral)
    rig = replace(stage.rig, names=names, deltas=stage.rig.deltas[rows], normal_deltas=normal, depiction=depiction)
    write_rig(folder / "b.npz", rig)
    write_png(folder / "drawing.png", stage.picture(stage.rig.neutral))
    write_parsing(folder / "labels.png", stage.regions(stage.rig.neutral))
    write_json(folder / "labels.json", legend(Region))
    for number, weights in enumerate(WEIGHTS):
        shape = head.evaluate() + sum(w * head.actions[head.action_names.index(name)] for name, w in weights.items())
        write_obj(folder / f"driver-{number}.obj", Mesh(shape, head.polygons, head.uvs, head.uv_polygons))
    return folder


def arguments(folder, *numbers):
    drivers = [folder / f"driver-{number}.obj" for number in numbers]
    given = ["--neutral", folder / "driver-0.obj", "--picture", folder / "drawing.png"]
    return [COMMAND, folder / "b.npz", *drivers, *given, "--parsing", folder / "labels.png"]


def test_a_picture_and_its_report(run, sitting, tmp_path):
    out = tmp_path / "open.png"
    result = run(*arguments(sitting, 1), "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: jawOpen 0.8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["open.json", "open.png"]
    old = read_image(sitting / "drawing.png")
    new = read_image(out)
    assert new.shape == old.shape and (new != old).any()
    np.testing.assert_array_equal(new[:80], old[:80])
    report = read_json(tmp_path / "open.json")
    assert report["unknown"] == [] and report["parsed"] and str(sitting / "drawing.png") in report["inputs"]


def test_a_calm_driver_leaves_the_picture(run, sitting, tmp_path):
    assert run(*arguments(sitting, 0), "--out", tmp_path / "calm.png").exit_code == 0
    np.testing.assert_array_equal(read_image(tmp_path / "calm.png"), read_image(sitting / "drawing.png"))


def test_a_transparent_drawing_stays_so(run, sitting, tmp_path):
    background = read_parsing(sitting / "labels.png")[0] == Region.BACKGROUND
    layer = np.dstack([read_image(sitting / "drawing.png"), np.where(background, 0, 255).astype(np.uint8)])
    layer[background, :3] = (48, 32, 33)
    drawing = tmp_path / "cut.png"
    write_png(drawing, layer)
    given = [drawing if word == sitting / "drawing.png" else word for word in arguments(sitting, 1)]
    result = run(*given, "--out", tmp_path / "open.png", "--film", tmp_path / "film.gif")
    assert result.exit_code == 0, result.output
    alpha = read_alpha(tmp_path / "open.png")
    new = read_image(tmp_path / "open.png", opaque=True)
    np.testing.assert_array_equal(new[:80], layer[:80, :, :3])
    np.testing.assert_array_equal(alpha[:80], layer[:80, :, 3])
    assert (alpha != layer[..., 3]).any() and (new[~background] != layer[~background, :3]).any()
    # A film is opaque, on white.
    assert (
        read_alpha(tmp_path / "film.gif") is None and (read_image(tmp_path / "film.gif")[background] > 250).mean() > 0.9
    )


def test_a_take_gives_pictures_and_a_film(run, sitting, tmp_path):
    film = tmp_path / "take.mp4"
    result = run(*arguments(sitting, 0, 1, 2), "--out-dir", tmp_path / "frames", "--film", film, "--fps", 5)
    assert result.exit_code == 0, result.output
    assert f"{film}: 3 frames at 5 a second" in result.stdout and film.stat().st_size > 1000
    assert len([*(tmp_path / "frames").glob("*.png")]) == 3
    report = read_json(film.with_suffix(".json"))
    np.testing.assert_allclose(report["weights"]["jawOpen"], [0, 0.8, 0], atol=0.02)
    result = run(*arguments(sitting, 0, 1, 0), "--film", tmp_path / "alone.gif", "--fps", 5)
    assert "alone.gif: 3 frames at 5 a second" in result.stdout
    weights = read_json(tmp_path / "alone.json")["weights"]["jawOpen"]
    np.testing.assert_allclose(weights, [0, 0.8, 0], atol=0.02)


def test_bad_input_is_one_line_and_leaves_nothing(refused, sitting, tmp_path):
    place = tmp_path / "out"
    out = ["--out", place / "a.png"]
    bare = tmp_path / "bare.npz"
    write_rig(bare, replace(read_rig(sitting / "b.npz"), depiction=None))
    small = tmp_path / "small.png"
    write_png(small, read_image(sitting / "drawing.png")[::3, ::3].copy())
    command, rig, driver, *others = arguments(sitting, 1)
    assert "camera" in refused(command, bare, driver, *others, *out)
    given = [command, rig, driver, "--neutral", sitting / "driver-0.obj"]
    assert "no head" in refused(*given, "--picture", small, *out)
    fast = ["--film", place / "a.gif", "--fps", 60]
    unread = tmp_path / "none.obj"
    assert "a.gif: expected from 0.002 to 50 frames" in refused(command, rig, unread, *others, *fast)
    labels = ["--parsing", sitting / "labels.png"]
    assert "size" in refused(*given, "--picture", small, *labels, *out)
    assert not place.exists()


def test_paint_follows_the_expression_in_the_picture_itself(run, sitting, tmp_path, head_template):
    network = write_brightener(tmp_path / "bright.safetensors", head_template.topology_id)
    still = tmp_path / "still.png"
    bright = tmp_path / "bright.png"
    assert run(*arguments(sitting, 1), "--out", still).exit_code == 0
    painting = ["--dynamic-texture", "--texture-network", network]
    result = run(*arguments(sitting, 1), *painting, "--out", bright)
    assert result.exit_code == 0, result.output
    away = read_image(bright).astype(int) - read_image(still)
    skin = read_parsing(sitting / "labels.png")[0] == Region.SKIN
    assert away[skin].max() > 10 and (away[skin].max(1) > 5).mean() > 0.2
    assert np.abs(away[:, :20]).max() == 0
    assert str(network) in read_json(tmp_path / "bright.json")["inputs"]


def test_the_picture_of_another_face_is_refused(refused, run, sitting, tmp_path):
    rig = read_rig(sitting / "b.npz")
    points = rig.depiction.camera.project(rig.neutral[load_model(kind="morphable").template.annotation.landmarks])
    kept = tmp_path / "kept.npz"
    write_rig(kept, replace(rig, depiction=replace(rig.depiction, landmarks=points.astype(np.float32))))
    command, _, *others = arguments(sitting, 1)
    other = tmp_path / "astronaut.png"
    write_png(other, cv2.resize(astronaut()[:240, 100:340], (200, 200), interpolation=cv2.INTER_AREA))
    out = ["--out", tmp_path / "new" / "open.png"]
    given = [command, kept, others[0], "--parsing", sitting / "labels.png", "--picture"]
    assert "another place" in refused(*given, other, *out)
    # The right one, darker, without its colours, and as JPEG, is taken.
    pixels = read_image(sitting / "drawing.png")
    edited = tmp_path / "edited.jpg"
    grey = np.repeat(0.8 * pixels.mean(2, keepdims=True), 3, axis=2).astype(np.uint8)
    cv2.imwrite(str(edited), grey, [cv2.IMWRITE_JPEG_QUALITY, 60])
    assert run(*given, edited, *out).exit_code == 0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--film", "a.mp4"], "--picture"),
        (["--parsing", "a.png", "--out", "a.obj"], "--picture"),
        (["--picture", "d.png", "--out", "a.obj"], ".png"),
        (["--picture", "d.png", "--out", "a.png", "--film", "a.mp4"], "names"),
        (["--picture", "d.png", "--film", "a.avi"], ".mp4"),
    ],
)
def test_wrong_usage(run, sitting, options, said):
    result = run(COMMAND, sitting / "b.npz", sitting / "driver-1.obj", *options)
    assert result.exit_code == 2 and said in result.stderr
