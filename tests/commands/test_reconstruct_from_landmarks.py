import shutil

import numpy as np
import pytest

from caricli.io.bundled import asset_path
from caricli.io.face import read_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.mesh import read_mesh
from caricli.io.meshes.obj import read_obj
from caricli.io.parsing import legend, write_parsing
from caricli.io.strict_json import read_json, write_json
from caricli.render.sheets.overlay import overlay_mesh
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import Camera, Landmarks
from caricli.structures.parsing import Region
from caricli.template.head import load_head

COMMAND = "reconstruct-from-landmarks"
NAMES = ["face.json", "face.npz", "face.obj", "face.png"]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    """A picture with two colours and an edge."""
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    picture = np.full((400, 400, 3), (40, 90, 200), np.uint8)
    picture[:, 200:] = 220, 180, 60
    write_png(path, picture)
    return path


@pytest.fixture(scope="module")
def reconstructed(run, points, photo, tmp_path_factory):
    """(folder with face.*, landmark file): the command with its defaults and a picture."""
    folder = tmp_path_factory.mktemp("done")
    marks = folder / "marks.json"
    write_landmarks(marks, Landmarks(points[:68], (400, 400)))
    result = run(COMMAND, marks, "--image", photo, "--out", folder / "out" / "face.obj")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{folder / 'out' / 'face.obj'}: NME 0.")
    return folder / "out", marks


def test_four_files_that_agree_with_each_other(reconstructed, head, points):
    folder, _ = reconstructed
    assert names(folder) == NAMES
    mesh, face, report = read_obj(folder / "face.obj"), read_face(folder / "face.npz"), read_json(folder / "face.json")
    np.testing.assert_array_equal(mesh.polygons, head.polygons)
    np.testing.assert_array_equal(mesh.uv_polygons, head.uv_polygons)
    np.testing.assert_allclose(mesh.uvs, head.uvs, atol=1e-6)
    np.testing.assert_allclose(face.vertices, mesh.vertices, atol=1e-7)
    np.testing.assert_array_equal(face.mesh.polygons, head.polygons)
    assert face.latent.shape == (128,) and face.residual.shape == (4200, 9)
    assert face.model_id == report["latent_model_id"] == load_model(kind=DEFAULT_LATENT).model_id != report["model_id"]
    projected = face.camera.scale * face.vertices @ face.camera.rotation[:2].T + face.camera.translation
    np.testing.assert_allclose(projected[report["anchors"]], face.landmarks, atol=1e-3)
    np.testing.assert_allclose(report["pose"]["rotation"], face.camera.rotation, atol=1e-9)
    np.testing.assert_allclose(report["pose"]["scale"], face.camera.scale)
    np.testing.assert_allclose(report["pose"]["translation"], face.camera.translation)
    diagonal = np.linalg.norm(np.ptp(points[:68], axis=0))
    error = 100 * np.linalg.norm(face.landmarks - points[:68], axis=1).mean() / diagonal
    np.testing.assert_allclose(report["nme"], error, rtol=1e-4)


def test_the_report_says_how_it_was_made_and_how_good_it_is(reconstructed, photo):
    folder, marks = reconstructed
    report = read_json(folder / "face.json")
    assert report["command"] == COMMAND and report["method"] == "intrinsic" and report["prior_weight"] == 1.0
    assert set(report["inputs"]) == {str(marks), str(photo)}
    assert report["nme"] < 1 and report["nme"] < report["nme_latent"]
    assert 0 < report["prior_rms"] < 1.5 and 0 <= report["flipped"] < 0.003
    assert set(report["part_errors"]) == {"jaw", "brows", "nose", "eyes", "mouth"}
    assert report["iterations"] == report["settings"]["rounds"] >= 4 and report["seconds"] > 0


def test_the_picture_shows_photo_landmarks_and_views(reconstructed):
    sheet = read_image(reconstructed[0] / "face.png").astype(int)
    height, width = sheet.shape[:2]
    assert width > 4 * height
    panels = [sheet[:, k * width // 5 : (k + 1) * width // 5] for k in range(5)]
    assert all(panel.std() > 10 for panel in panels)

    def count(panel, colour):
        return (np.abs(panel - colour).sum(-1) < 45).sum()

    for colour in ((40, 90, 200), (220, 180, 60)):
        assert count(panels[0], colour) > 0.1 * height**2
        assert all(count(panel, colour) == 0 for panel in panels[2:])
    green, red = (30, 160, 70), (215, 40, 40)
    assert count(panels[0], green) > 40 and count(panels[0], red) > 40
    assert all(count(panel, green) == 0 for panel in panels[1:])


def test_the_format_of_the_landmarks_does_not_matter(run, reconstructed, points, tmp_path):
    for suffix in ("pts", "txt", "npy"):
        write_landmarks(tmp_path / f"{suffix}.{suffix}", Landmarks(points[:68]))
    result = run(COMMAND, *tmp_path.iterdir(), "--out-dir", tmp_path / "out")
    assert result.exit_code == 0, result.output
    expected = read_face(reconstructed[0] / "face.npz")
    for suffix in ("pts", "txt", "npy"):
        found = read_face(tmp_path / "out" / f"{suffix}.npz")
        np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-6)
        np.testing.assert_allclose(found.landmarks, expected.landmarks, atol=1e-3)


def test_pts_from_0_are_a_pixel_away(run, points, models, tmp_path):
    write_landmarks(tmp_path / "marks.pts", Landmarks(points[:68]))
    found = []
    for origin in (0, 1):
        arguments = (tmp_path / "marks.pts", "--out", tmp_path / f"{origin}.obj", "--pts-origin", origin)
        assert run(COMMAND, *arguments, "--model", models["intrinsic"]).exit_code == 0
        found.append(read_face(tmp_path / f"{origin}.npz").landmarks)
    np.testing.assert_allclose(found[0] - found[1], 1, atol=1e-3)


def test_same_input_same_bytes_but_for_the_time(run, reconstructed, photo, tmp_path):
    folder, marks = reconstructed
    assert run(COMMAND, marks, "--image", photo, "--out", tmp_path / "face.obj").exit_code == 0
    for name in ("face.obj", "face.npz", "face.png"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
    first, second = (read_json(path / "face.json") | {"seconds": 0} for path in (folder, tmp_path))
    assert first == second


def test_the_latent_method_stays_in_the_model(run, marks, tmp_path):
    assert run(COMMAND, marks, "--out", tmp_path / "face.obj", "--method", "latent").exit_code == 0
    face, report = read_face(tmp_path / "face.npz"), read_json(tmp_path / "face.json")
    assert face.residual is None and report["method"] == "latent"
    assert report["nme"] == report["nme_latent"] < 2
    assert set(report["settings"]) == {"noise", "rounds", "refinements"}


def test_a_finer_mesh_begins_with_the_plain_one(run, reconstructed, photo, tmp_path):
    plain, marks = reconstructed
    result = run(COMMAND, marks, "--image", photo, "--out", tmp_path / "face.obj", "--subdivide", 1)
    assert result.exit_code == 0, result.output
    coarse, fine = (read_obj(folder / "face.obj") for folder in (plain, tmp_path))
    assert len(fine.vertices) == 16_755 and len(fine.polygons) == 4 * len(coarse.polygons)
    assert np.abs(fine.vertices[:4200] - coarse.vertices).max() < 1e-6
    assert (tmp_path / "face.npz").read_bytes() == (plain / "face.npz").read_bytes()
    assert read_json(plain / "face.json")["subdivide"] == 0 and read_json(tmp_path / "face.json")["subdivide"] == 1
    pictures = [read_image(folder / "face.png").astype(int) for folder in (plain, tmp_path)]
    assert 0 < np.abs(pictures[0] - pictures[1]).mean() < 3


def test_too_fine_a_mesh_is_refused(refused, models, marks, tmp_path):
    out = tmp_path / "new" / "face.obj"
    said = refused(COMMAND, marks, "--out", out, "--model", models["intrinsic"], "--subdivide", 4)
    assert "subdivision beyond the memory cap" in said and not out.parent.exists()


def test_81_points_some_of_them_unknown(run, points, models, tmp_path):
    known = points.copy()
    known[[3, 20, 75]] = np.nan
    write_landmarks(tmp_path / "marks.json", Landmarks(known, (400, 400)))
    result = run(COMMAND, tmp_path / "marks.json", "--out", tmp_path / "face.obj", "--model", models["intrinsic"])
    assert result.exit_code == 0, result.output
    assert read_face(tmp_path / "face.npz").landmarks.shape == (81, 2)
    assert "extra" in read_json(tmp_path / "face.json")["part_errors"]


@pytest.mark.parametrize("method", ["intrinsic", "latent"])
def test_a_larger_prior_weight_is_more_careful(run, models, marks, tmp_path, method):
    spread, model = [], models["intrinsic" if method == "intrinsic" else "pca"]
    for weight in (0.2, 5):
        out = tmp_path / f"face{weight}.obj"
        options = ("--method", method, "--model", model, "--prior-weight", weight)
        assert run(COMMAND, marks, "--out", out, *options).exit_code == 0
        spread.append(read_json(out.with_suffix(".json"))["prior_rms"])
    assert spread[0] > 1.2 * spread[1]


# ---------------------------------------------------------------- many inputs


@pytest.fixture
def batch(points, tmp_path):
    """A folder with a.txt, b.txt and a bad c.txt."""
    folder = tmp_path / "marks"
    folder.mkdir()
    write_landmarks(folder / "a.txt", Landmarks(points[:68]))
    write_landmarks(folder / "b.txt", Landmarks(0.5 * points[:68]))
    (folder / "c.txt").write_text("1 2\n" * 68)
    return folder


def test_a_bad_input_does_not_stop_the_others(run, models, batch, tmp_path):
    out = tmp_path / "out"
    inputs = [batch / "c.txt", batch / "a.txt", batch / "missing.txt", batch / "b.txt"]
    result = run(COMMAND, *inputs, "--out-dir", out, "--model", models["intrinsic"])
    assert result.exit_code == 1
    assert names(out) == [f"{stem}.{suffix}" for stem in "ab" for suffix in ("json", "npz", "obj", "png")]
    assert [line.split(":")[0] for line in result.stdout.splitlines()] == [str(out / "a.obj"), str(out / "b.obj")]
    lines = result.stderr.splitlines()
    assert len(lines) == 3 and "2 of 4" in lines[-1]
    assert "c.txt" in lines[0] and "one place" in lines[0] and "missing.txt" in lines[1]
    a, b = (read_face(out / name).vertices for name in ("a.npz", "b.npz"))
    np.testing.assert_allclose(a, b, atol=1e-6)


def test_pictures_of_many_inputs_come_from_a_folder(run, models, batch, photo, tmp_path):
    shutil.copy(photo, tmp_path / "a.png")
    arguments = (batch / "a.txt", batch / "b.txt", "--out-dir", tmp_path / "out", "--model", models["intrinsic"])
    result = run(COMMAND, *arguments, "--image", tmp_path)
    assert result.exit_code == 1
    assert names(tmp_path / "out") == ["a.json", "a.npz", "a.obj", "a.png"]
    assert "b.txt" in result.stderr and "picture named b" in result.stderr
    assert str(tmp_path / "a.png") in read_json(tmp_path / "out" / "a.json")["inputs"]


def test_one_input_fails_as_one_line_into_a_folder_too(refused, models, batch, tmp_path):
    said = refused(COMMAND, batch / "c.txt", "--out-dir", tmp_path / "out", "--model", models["intrinsic"])
    assert "c.txt" in said and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["a.txt"],
        ["a.txt", "--out", "x.obj", "--out-dir", "y"],
        ["a.txt", "b.txt", "--out", "x.obj"],
        ["a.txt", "--out", "x.png"],
        ["a.txt", "a.json", "--out-dir", "y"],
        ["a.txt", "--out", "x.obj", "--method", "magic"],
        ["a.txt", "--out", "x.obj", "--prior-weight", "0"],
        ["a.txt", "--out", "x.obj", "--prior-weight", "nan"],
        ["a.txt", "--out", "x.obj", "--subdivide", "5"],
        ["a.txt", "--out", "x.obj", "--pts-origin", "2"],
    ],
)
def test_wrong_usage_is_2(run, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    result = run(COMMAND, *arguments)
    assert result.exit_code == 2 and result.stdout == "" and result.stderr.count("\n") == 1
    assert names(tmp_path) == []


# ---------------------------------------------------------------- bad input


def lines(count):
    generator = np.random.default_rng(0)
    return "".join(f"{x} {y}\n" for x, y in generator.uniform(0, 400, (count, 2))).encode()


def json_of(points, **more):
    value = {"schema": "caricli.landmarks/1", "scheme": "ibug68", "image": {"width": 400, "height": 400}}
    return lambda path: write_json(path, value | {"points": points} | more)


POINTS = np.random.default_rng(1).uniform(50, 350, (68, 2)).tolist()
BAD = {
    "missing": ("x.json", None, "no such file"),
    "a folder": ("x.json", lambda path: path.mkdir(), "folder"),
    "empty": ("x.json", b"", "empty"),
    "HTML as JSON": ("x.json", b"<!doctype html><html></html>", "HTML"),
    "HTML as text": ("x.txt", b"<html><body>404</body></html>", "HTML"),
    "HTML as pts": ("x.pts", b"<html>", "HTML"),
    "rubbish as NPY": ("x.npy", b"\x00\x01\x02" * 100, "x.npy"),
    "a pickle as NPY": ("x.npy", b"\x80\x04\x95\x05\x00\x00\x00\x00\x00\x00\x00]\x94.", "pickle"),
    "67 points": ("x.txt", lines(67), "found 67"),
    "69 points": ("x.txt", lines(69), "found 69"),
    "67 in JSON": ("x.json", json_of(POINTS[:67]), "found 67"),
    "one place": ("x.txt", b"5 5\n" * 68, "one place"),
    "not a number": ("x.txt", lines(67) + b"nan 3\n", "line 68"),
    "infinite": ("x.txt", lines(67) + b"inf 3\n", "line 68"),
    "1e308": ("x.txt", lines(67) + b"1e308 3\n", "line 68"),
    "NaN in JSON": ("x.json", b'{"schema": NaN}', "x.json"),
    "twice the same key": ("x.json", b'{"schema": 1, "schema": 2}', "schema"),
    "deep": ("x.json", b"[" * 100_000, "x.json"),
    "invalid UTF-8": ("x.json", b'{"\xff": 1}', "UTF-8"),
    "far outside": ("x.json", json_of([*POINTS[:67], [5000.0, 3.0]]), "point 67"),
    "7 known": ("x.json", json_of([*POINTS[:7], *[None] * 61]), "at least 8"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_landmarks_are_one_line_and_leave_nothing(refused, models, tmp_path, case):
    name, content, word = BAD[case]
    path, out = tmp_path / name, tmp_path / "new" / "face.obj"
    if callable(content):
        content(path)
    elif content is not None:
        path.write_bytes(content)
    said = refused(COMMAND, path, "--out", out, "--model", models["intrinsic"])
    assert name in said and word in said
    assert not out.parent.exists()


@pytest.mark.parametrize("content", [None, b"", b"<html>", b"\x89PNG\r\n\x1a\n rubbish", b"GIF89a"])
def test_bad_pictures_are_one_line_and_leave_nothing(refused, models, marks, tmp_path, content):
    image = tmp_path / "drawing.png"
    if content is not None:
        image.write_bytes(content)
    out = tmp_path / "new" / "face.obj"
    said = refused(COMMAND, marks, "--image", image, "--out", out, "--model", models["intrinsic"])
    assert "drawing.png" in said
    assert not out.parent.exists()


def test_landmarks_that_cannot_belong_to_the_picture_are_refused(refused, models, points, photo, tmp_path):
    out, model = tmp_path / "new" / "face.obj", models["intrinsic"]
    write_landmarks(tmp_path / "far.txt", Landmarks(points[:68] + [900.0, 0.0]))
    write_landmarks(tmp_path / "other.json", Landmarks(points[:68], (640, 480)))
    for name, word in (("far.txt", "400 x 400"), ("other.json", "640 x 480")):
        said = refused(COMMAND, tmp_path / name, "--image", photo, "--out", out, "--model", model)
        assert name in said and word in said
    assert not out.parent.exists()


def truncated(path):
    path.write_bytes(asset_path("pca.safetensors").read_bytes()[:-1000])


BAD_MODELS = {
    "missing": (None, "no such file"),
    "a folder": (lambda path: path.mkdir(), "folder"),
    "empty": (b"", "empty"),
    "HTML": (b"<!doctype html>" + b" " * 100, "m.safetensors"),
    "a pickle": (b"\x80\x04\x95\x05\x00\x00\x00\x00\x00\x00\x00]\x94.", "pickle"),
    "a zip, as torch saves": (b"PK\x03\x04" + b"\x00" * 100, "m.safetensors"),
    "truncated": (truncated, "m.safetensors"),
    "a header that lies": (b"\xff\xff\xff\xff\xff\xff\xff\x7f{}", "m.safetensors"),
}


@pytest.mark.parametrize("case", BAD_MODELS)
def test_bad_models_are_one_line_and_leave_nothing(refused, marks, tmp_path, case):
    content, word = BAD_MODELS[case]
    path, out = tmp_path / "m.safetensors", tmp_path / "new" / "face.obj"
    if callable(content):
        content(path)
    elif content is not None:
        path.write_bytes(content)
    for method in ("intrinsic", "latent"):
        said = refused(COMMAND, marks, "--out", out, "--model", path, "--method", method)
        assert "m.safetensors" in said and word in said
    assert not out.parent.exists()


def test_a_model_that_cannot_follow_elastically_is_fitted_inside(run, refused, models, marks, tmp_path):
    pca = ("--out", tmp_path / "face.obj", "--model", models["pca"])
    said = refused(COMMAND, marks, *pca, "--method", "intrinsic")
    assert "needs an intrinsic model, found one of kind 'pca', which 'latent' fits" in said
    assert names(tmp_path) == ["marks.json"]
    result = run(COMMAND, marks, *pca)
    assert result.exit_code == 0, result.output
    report = read_json(tmp_path / "face.json")
    assert report["method"] == "latent" and report["model_id"] == read_face(tmp_path / "face.npz").model_id


@pytest.mark.parametrize("name", NAMES)
def test_what_exists_is_kept_unless_told_otherwise(run, refused, models, marks, tmp_path, name):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / name).write_text("mine")
    arguments = (marks, "--out", folder / "face.obj", "--model", models["intrinsic"])
    said = refused(COMMAND, *arguments)
    assert f"{name} exists" in said and "--overwrite" in said
    assert names(folder) == [name] and (folder / name).read_text() == "mine"
    if name == "face.png":
        assert run(COMMAND, *arguments, "--overwrite").exit_code == 0
        assert names(folder) == NAMES and read_image(folder / name).std() > 10


def test_an_output_is_never_an_input(refused, models, marks, photo, tmp_path):
    model = ("--model", models["intrinsic"], "--overwrite")
    before = marks.read_bytes()
    assert "marks.json" in refused(COMMAND, marks, "--out", tmp_path / "marks.obj", *model)
    image = shutil.copy(photo, tmp_path / "face.png")
    said = refused(COMMAND, marks, "--image", image, "--out", tmp_path / "face.obj", *model)
    assert "face.png" in said and "input" in said
    (tmp_path / "link.json").symlink_to(marks)
    assert "link.json" in refused(COMMAND, marks, "--out", tmp_path / "link.obj", *model)
    (tmp_path / "same.npz").hardlink_to(models["intrinsic"])
    assert "same.npz" in refused(COMMAND, marks, "--out", tmp_path / "same.obj", *model)
    assert marks.read_bytes() == before and image.read_bytes() == photo.read_bytes()
    assert names(tmp_path) == ["face.png", "link.json", "marks.json", "same.npz"]


def test_the_suffix_says_the_format_of_the_mesh(run, reconstructed, tmp_path):
    folder, marks = reconstructed
    result = run(COMMAND, marks, "--out", tmp_path / "face.ply")
    assert result.exit_code == 0, result.output
    assert names(tmp_path) == ["face.json", "face.npz", "face.ply", "face.png"]
    np.testing.assert_allclose(
        read_mesh(tmp_path / "face.ply").vertices, read_obj(folder / "face.obj").vertices, atol=1e-6
    )


def test_ears_are_found_in_the_picture_unless_nobody_shall_look(run, head_template, tmp_path):
    big = {f"{side}-ear-{name}": 1.8 for side in "lr" for name in ("scale-incr", "wing-incr")}
    face = head_template.with_vertices(load_head().evaluate(changes=big))
    camera = Camera(1400.0, np.diag([1.0, -1.0, -1.0]), np.array([200.0, 390.0]))
    write_png(
        tmp_path / "face.png", overlay_mesh(np.full((400, 400, 3), (70, 110, 160), np.uint8), face, camera, opacity=1)
    )
    marks = tmp_path / "marks.json"
    write_landmarks(
        marks, Landmarks(camera.project(face.vertices[head_template.annotation.landmarks[:68]]), (400, 400))
    )
    reports = {}
    for outline in ("auto", "none"):
        out = tmp_path / outline / "face.obj"
        result = run(COMMAND, marks, "--image", tmp_path / "face.png", "--out", out, "--outline", outline)
        assert result.exit_code == 0, result.output
        reports[outline] = read_json(out.with_suffix(".json"))
        reports[outline]["width"] = np.ptp(read_obj(out).vertices[:, 0])
    assert reports["auto"]["found_landmarks"]["ear_left_outer"]["confidence"] > 0.1
    assert "found_landmarks" not in reports["none"]
    assert (reports["auto"]["iterations"], reports["none"]["iterations"]) == (15, 10)
    assert reports["auto"]["width"] > 1.1 * reports["none"]["width"]


def test_regions_count_for_landmarks_that_were_all_marked_by_hand(
    run, refused, photo, head_template, monkeypatch, tmp_path
):
    camera = Camera(1400.0, np.diag([1.0, -1.0, -1.0]), np.array([200.0, 390.0]))
    marks, labels = tmp_path / "marks.json", tmp_path / "labels.png"
    points = camera.project(head_template.vertices[head_template.annotation.landmarks])
    write_landmarks(marks, Landmarks(points, (400, 400)))
    write_parsing(labels, np.full((400, 400), Region.SKIN, np.uint8))
    write_json(labels.with_suffix(".json"), legend(Region))
    seen = []

    def fit_ears(face, template, picture):
        seen.append(picture.regions)
        return face

    monkeypatch.setattr("caricli.methods.reconstruct.fit_ears.fit_ears", fit_ears)
    given = (COMMAND, marks, "--image", photo, "--parsing", labels, "--out", tmp_path / "face.obj")
    assert len(points) == 81 and run(*given).exit_code == 0
    np.testing.assert_array_equal(seen, [np.full((400, 400), Region.SKIN)])
    assert run(*given[:4], "--out", tmp_path / "looked.obj").exit_code == 0
    assert len(seen) == 2 and seen[1].shape == (400, 400)
    assert run(*given[:4], "--out", tmp_path / "blind.obj", "--outline", "none").exit_code == 0
    assert len(seen) == 2
    write_parsing(labels, np.full((200, 400), Region.SKIN, np.uint8))
    assert f"{labels}: expected the picture's size, 400 x 400, found 400 x 200" in refused(*given, "--overwrite")


def test_a_label_map_is_of_the_picture_of_one_landmark_file(run, refused, photo, reconstructed, tmp_path):
    _, marks = reconstructed
    labels = tmp_path / "labels.png"
    write_parsing(labels, np.full((400, 400), Region.SKIN, np.uint8))
    write_json(labels.with_suffix(".json"), legend(Region))
    given = (COMMAND, marks, "--image", photo, "--parsing", labels, "--out", tmp_path / "face.obj")
    assert run(*given).exit_code == 0
    assert set(read_json(tmp_path / "face.json")["inputs"]) == {str(marks), str(photo), str(labels)}
    for wrong in ((photo, "--out"), (marks, "--out"), (marks, "--image", tmp_path, "--out-dir")):
        said = refused(COMMAND, *wrong, tmp_path / "other.obj", "--parsing", labels, code=2)
        assert "--parsing is of the --image of one landmark file" in said
    assert "--outline none looks for none" in refused(*given, "--overwrite", "--outline", "none", code=2)
    write_parsing(labels, np.full((200, 400), Region.SKIN, np.uint8))
    assert f"{labels}: expected the picture's size, 400 x 400, found 400 x 200" in refused(*given, "--overwrite")


def test_all_json_files_beside_detected_landmarks_may_be_given(run, points, tmp_path):
    write_landmarks(tmp_path / "a.json", Landmarks(points[:68], (400, 400)))
    write_json(tmp_path / "a-regions.json", legend(Region))
    result = run(COMMAND, *sorted(tmp_path.glob("*.json")), "--out-dir", tmp_path / "faces", "--no-picture")
    assert result.exit_code == 0, result.output
    assert names(tmp_path / "faces") == ["a.json", "a.npz", "a.obj"]
    alone = run(COMMAND, tmp_path / "a-regions.json", "--out-dir", tmp_path / "faces")
    assert alone.exit_code == 1 and "expected the schema 'caricli.landmarks/1'" in alone.stderr
