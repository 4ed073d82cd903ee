import numpy as np
import pytest

from caricli.io.face import read_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import read_json
from caricli.store.models import load_model
from caricli.structures import Mesh

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture(scope="module")
def people(head, tmp_path_factory):
    """Two OBJ files, one with an expression."""
    folder = tmp_path_factory.mktemp("people")
    for name, more in (("a", {"gender": 0.1, "weight": 0.9}), ("b", {"age": 0.9, "actions": {"jawOpen": 0.4}})):
        mesh = Mesh(head.evaluate(**more), head.polygons, head.uvs, head.uv_polygons)
        write_obj(folder / f"{name}.obj", mesh)
    return folder / "a.obj", folder / "b.obj"


@pytest.fixture(params=["kernel", "intrinsic"])
def known(request, models, directions):
    return ("--model", models[request.param], "--directions", directions[request.param])


@pytest.fixture
def pca(models, directions):
    return ("--model", models["pca"], "--directions", directions["pca"])


def test_along_the_direction_of_caricatures(run, people, known, tmp_path):
    out = tmp_path / "new" / "c.obj"
    result = run("caricaturize", people[1], "--strength", 2, "--out", out, *known)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: ") and "b.obj: had no latent" in result.stderr
    assert sorted(path.name for path in out.parent.iterdir()) == ["c.json", "c.npz", "c.obj", "c.png"]
    report, face, model = read_json(out.with_suffix(".json")), read_face(out.with_suffix(".npz")), load_model(known[1])
    before, after = (report[when]["exaggeration"]["caricature"] for when in ("before", "after"))
    assert after - before == pytest.approx(2, abs=1e-6)
    kept = report["identity"]["own"] < report["identity"]["nearest_other"]
    assert report["identity"]["people"] == 5 and report["identity"]["kept"] == kept
    assert (report["mode"], report["strength"]) == ("direction", 2)
    step = model.prior.whiten(face.latent) - model.prior.whiten(model.encode(read_obj(people[1]).vertices))
    np.testing.assert_allclose(step, [0, 0, 2, 0, 0], atol=1e-4)


def test_its_own_way_goes_away_from_the_mean_and_keeps_size_and_place(run, people, known, tmp_path):
    distances, start = [], read_obj(people[0]).vertices
    for strength in (0, 0.5, 1, 2):
        out = tmp_path / f"{strength}.obj"
        result = run("caricaturize", people[0], "--mode", "own", "--strength", strength, "--out", out, *known)
        assert result.exit_code == 0, result.output
        report = read_json(out.with_suffix(".json"))
        distances.append(report["after"]["exaggeration"]["distance"])
        assert report["after"]["flipped"] < 0.003
    assert distances[0] == pytest.approx(report["before"]["exaggeration"]["distance"])
    assert np.all(np.diff(distances) > 0) and distances[-1] > 1.4 * distances[0]
    np.testing.assert_allclose(read_obj(tmp_path / "0.obj").vertices, start, atol=1e-6)
    grown, place = read_obj(out).vertices, load_model(known[1]).template.region("face")
    assert np.abs(grown[place].mean(0) - start[place].mean(0)).max() < 1e-3
    assert 0.8 < np.ptp(grown[place], axis=0).prod() / np.ptp(start[place], axis=0).prod() < 1.25


def test_the_mean_head_has_no_own_way(run, head, pca, tmp_path):
    template = load_model(pca[1]).template
    write_obj(tmp_path / "mean.obj", Mesh(template.vertices + 0.01, head.polygons))
    out = tmp_path / "c.obj"
    assert (
        run("caricaturize", tmp_path / "mean.obj", "--mode", "own", "--strength", 2, "--out", out, *pca).exit_code == 0
    )
    assert np.abs(read_obj(out).vertices - template.vertices - 0.01).max() < 2e-4


def test_its_own_way_needs_no_directions(run, refused, people, models, tmp_path):
    options = ("--out", tmp_path / "c.obj", "--model", models["pca"])
    result = run("caricaturize", people[0], "--mode", "own", *options)
    assert result.exit_code == 0, result.output
    report = read_json(tmp_path / "c.json")
    assert "identity" not in report and list(report["after"]["exaggeration"]) == ["distance"]
    assert "directions are of the bundled pca model" in refused("caricaturize", people[0], *options, "--overwrite")


def test_from_landmarks_with_a_picture(run, marks, known, tmp_path):
    write_png(tmp_path / "photo.png", np.full((400, 400, 3), 90, np.uint8))
    options = ("--from-landmarks", "--image", tmp_path / "photo.png", "--strength", 0)
    result = run("caricaturize", marks, *options, "--out", tmp_path / "c.obj", *known)
    assert result.exit_code == 0, result.output
    assert "marks.json: reconstructed, NME 0." in result.stderr
    face, points = read_face(tmp_path / "c.npz"), read_landmarks(marks).points
    assert face.camera.scale > 0 and face.landmarks.shape == points.shape
    # Nothing was exaggerated: the head still lies under its landmarks.
    note = load_model(known[1]).template.annotation
    seen = face.camera.project(face.vertices)
    away = np.linalg.norm(seen[note.landmarks[17:68]] - points[17:], axis=1).mean()
    assert away < 0.02 * np.linalg.norm(np.ptp(points, axis=0))
    assert set(read_json(tmp_path / "c.json")["inputs"]) == {str(marks), str(tmp_path / "photo.png"), str(known[3])}
    with_picture = read_image(tmp_path / "c.png").shape
    run("caricaturize", marks, "--from-landmarks", "--out", tmp_path / "d.obj", *known)
    assert with_picture[1] > read_image(tmp_path / "d.png").shape[1]


def test_zero_based_landmarks_and_other_formats(run, points, pca, tmp_path):
    rows = "".join(f"{x} {y}\n" for x, y in points[:68])
    (tmp_path / "marks.pts").write_text(f"version: 1\nn_points: 68\n{{\n{rows}}}\n")
    places = []
    for origin in (1, 0):
        out = tmp_path / f"{origin}.glb"
        options = ("--from-landmarks", "--pts-origin", origin, "--strength", 0, "--out", out)
        result = run("caricaturize", tmp_path / "marks.pts", *options, *pca)
        assert result.exit_code == 0, result.output
        assert out.read_bytes()[:4] == b"glTF"
        places.append(read_face(tmp_path / f"{origin}.npz").landmarks)
    np.testing.assert_allclose(places[1] - places[0], 1, atol=1e-6)


def test_a_bad_item_does_not_stop_the_others(run, people, pca, tmp_path):
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 nan\n")
    result = run("caricaturize", people[0], bad, people[1], "--out-dir", tmp_path / "out", *pca)
    assert result.exit_code == 1 and "bad.obj" in result.stderr and "1 of 3 failed" in result.stderr
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == [f"{name}.{suffix}" for name in "ab" for suffix in ("json", "npz", "obj", "png")]


def test_bad_input_is_one_line_and_leaves_nothing(refused, people, models, directions, pca, marks, run, tmp_path):
    out = tmp_path / "new" / "c.obj"

    def check(*words, face=people[0], options=pca):
        said = refused("caricaturize", face, "--out", out, *options)
        assert all(word in said for word in words), said

    check("none.obj", face=tmp_path / "none.obj")
    check("directions are of", options=("--model", models["pca"], "--directions", directions["kernel"]))
    check("marks.json", face=marks)
    check("a.obj", options=(*pca, "--from-landmarks"))
    assert run("encode", people[0], "--out", tmp_path / "other.npz", "--model", models["kernel"]).exit_code == 0
    check("other.npz: its latent is of", face=tmp_path / "other.npz")
    write_png(tmp_path / "small.png", np.zeros((100, 100, 3), np.uint8))
    check("400", face=marks, options=(*pca, "--from-landmarks", "--image", tmp_path / "small.png"))
    assert not out.parent.exists()


@pytest.mark.parametrize(
    "options", [["--strength", "nan"], ["--strength", "-1"], ["--mode", "x"], ["--image", "x.png"], ["--out-dir", "y"]]
)
def test_wrong_usage_is_2(run, people, pca, tmp_path, options):
    result = run("caricaturize", people[0], "--out", tmp_path / "c.obj", *options, *pca)
    assert result.exit_code == 2 and result.stdout == ""
