import re
import shutil
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from caricli.commands.rig import _advise
from caricli.io.bundled import asset_path
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image, write_png
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.rig import read_rig
from caricli.io.strict_json import read_json
from caricli.methods.rig.measure_rig import curve_gap
from caricli.store.models import model_path
from caricli.structures import Material, Mesh
from caricli.structures.arkit import ARKIT_NAMES

pytestmark = pytest.mark.usefixtures("quick_pictures")

WIDE = [1.15, 0.9, 1.2]


@pytest.fixture
def undrawn(monkeypatch):
    """No contact sheet."""
    monkeypatch.setattr(
        "caricli.render.sheets.expression_sheet.expression_sheet",
        lambda rig, progress, given: np.zeros((4, 4, 3), np.uint8),
    )


@pytest.fixture(scope="module")
def face(head, tmp_path_factory):
    """An OBJ of a caricature of the open head with a picture on it."""
    path = tmp_path_factory.mktemp("face") / "face.obj"
    vertices = head.evaluate(gender=0.1, age=0.8, weight=0.7) * WIDE
    write_png(path.with_name("skin.png"), np.random.default_rng(1).integers(0, 256, (16, 16, 3), np.uint8))
    write_obj(path, Mesh(vertices, head.polygons, head.uvs, head.uv_polygons), texture="skin.png")
    return path


@pytest.fixture(scope="module")
def rigged(run, face, quick_pictures):
    """The path of its rig, made by the command, and what the command said."""
    out = face.parent / "new" / "rig.glb"
    result = run("rig", face, "--out", out)
    assert result.exit_code == 0, result.output
    return out, result


@pytest.fixture
def scans(egg, tmp_path):
    """A folder of eggs: a neutral one and three expressions."""
    folder = tmp_path / "expressions"
    folder.mkdir()
    for number, name in enumerate(("Neutral", "jawOpen", "mouthClose", "Grin")):
        egg.write(folder / f"{name}.obj", np.eye(5)[number][1:] * 0.7)
    return folder


@pytest.fixture
def target(egg, tmp_path):
    """The path of a stretched egg."""
    path = tmp_path / "scan.obj"
    egg.write(path, np.array([0, 0, 0, 0.8]))
    mesh = read_obj(path)
    write_obj(path, Mesh(mesh.vertices * WIDE, mesh.polygons, mesh.uvs, mesh.uv_polygons))
    return path


def test_a_head_gets_arkits_expressions_and_eyes(rigged, face, head):
    out, result = rigged
    assert sorted(path.name for path in out.parent.iterdir()) == ["rig.glb", "rig.json", "rig.npz", "rig.png"]
    assert result.stdout.startswith(f"{out}: 52 expressions (5") and result.stdout.count("\n") == 1
    assert re.search(r"lids close to 0\.\d %, lips to \d\.\d %, flipped triangles at most 0\.[01]\d* %", result.stdout)
    rig = read_rig(out.with_suffix(".npz"))
    assert sorted(rig.names) == sorted(ARKIT_NAMES) and len(rig.neutral) > 4200
    np.testing.assert_allclose(rig.neutral[:4200], read_obj(face).vertices, atol=1e-6)
    np.testing.assert_array_equal(rig.mesh.polygons[: len(head.polygons)], head.polygons)
    np.testing.assert_array_equal(rig.pictures.skin, read_image(face.with_name("skin.png")))
    picture = read_image(out.with_suffix(".png"))
    assert picture.shape[1] >= 9 * 48 and picture.shape[0] >= 6 * 48


def test_the_glb_holds_the_same(rigged):
    out, _ = rigged
    rig, glb = read_rig(out.with_suffix(".npz")), read_gltf(out)
    assert glb.names == rig.names
    for key in ("neutral", "deltas"):
        np.testing.assert_allclose(getattr(glb, key), getattr(rig, key), atol=1e-6)
    assert glb.pictures.same(rig.pictures)
    np.testing.assert_array_equal(np.sort(np.sort(glb.faces, 1), 0), np.sort(np.sort(rig.faces, 1), 0))


def test_the_report_says_how_sound_every_expression_is(rigged, face):
    report = read_json(rigged[0].with_suffix(".json"))
    assert report["command"] == "rig" and report["seed"] == 0 and report["units"] == "m"
    assert set(report["inputs"]) == {str(face), str(face.with_name("skin.png"))}
    rows = report["expressions"]
    assert set(rows) == set(ARKIT_NAMES)
    for name, row in rows.items():
        assert 0 <= row["flipped"] <= 0.002 and 0.2 < row.get("strength", 1) < 5, name
        assert all(re.fullmatch(r"AU\d+", unit) for unit in row["action_units"]) and "facs46" in row, name
    assert sum(row["facs46"] is not None for row in rows.values()) == 46
    assert rows["eyeBlinkLeft"]["contact_gap"] < 0.5 and "contact_gap" not in rows["browInnerUp"]
    assert max(report["lid_gap"].values()) < 0.1 and report["lip_gap"] < 0.1 and report["lids_inside_eyeballs"] < 0
    for ball, side in zip(report["eyeballs"], ("left", "right"), strict=True):
        assert ball["side"] == side and ball["retreat"] >= 0 and 0.005 < ball["radius"] < 0.05
        assert np.sign(ball["centre"][0]) == (1 if side == "left" else -1)


def test_plain_fine_and_sparse(run, rigged, face, undrawn, tmp_path):
    plain, fine = tmp_path / "plain.glb", tmp_path / "fine.glb"
    assert run("rig", face, "--parts", "skin", "--sparse", "--out", plain).exit_code == 0
    rig = read_rig(plain.with_suffix(".npz"))
    assert len(rig.neutral) == 4200 and rig.pictures.eyes is None
    assert plain.stat().st_size < 0.7 * rigged[0].stat().st_size
    np.testing.assert_allclose(read_gltf(plain).deltas, rig.deltas, atol=1e-6)
    report = read_json(plain.with_suffix(".json"))
    assert report["eyeballs"] == [] and "lids_inside_eyeballs" not in report and report["sparse"] is True
    assert run("rig", face, "--subdivide", 1, "--sparse", "--out", fine).exit_code == 0
    finer = read_rig(fine.with_suffix(".npz"))
    assert len(finer.neutral) > 3 * 4200
    np.testing.assert_allclose(finer.deltas[:, :4200], rig.deltas, atol=1e-6)


def test_ones_own_expressions(run, scans, target, egg, tmp_path):
    out = tmp_path / "rig.glb"
    result = run("rig", target, "--templates", scans, "--out", out)
    assert result.exit_code == 0, result.output
    rig = read_rig(out.with_suffix(".npz"))
    assert rig.names == ("Grin", "jawOpen", "mouthClose") and rig.pictures.skin is None
    np.testing.assert_allclose(rig.neutral, read_obj(target).vertices, atol=1e-6)
    np.testing.assert_array_equal(rig.mesh.polygons, egg.polygons)
    report = read_json(out.with_suffix(".json"))
    assert report["expressions"]["jawOpen"]["action_units"] and "action_units" not in report["expressions"]["Grin"]
    assert len(report["inputs"]) == 5 and "lid_gap" not in report
    # Onto their own neutral they come back, but for where they are: nothing is held.
    own = run("rig", scans / "Neutral.obj", "--templates", scans, "--out", tmp_path / "own.glb")
    assert own.exit_code == 0, own.output
    rig = read_rig(tmp_path / "own.npz")
    grin = read_obj(scans / "Grin.obj").vertices - read_obj(scans / "Neutral.obj").vertices
    np.testing.assert_allclose(rig.deltas[0], grin, atol=1e-5)


def test_a_model_says_where_eyes_and_neck_of_an_own_mesh_are(run, head, head_template, undrawn, tmp_path):
    folder = tmp_path / "expressions"
    folder.mkdir()
    for name, actions in (("neutral", {}), ("jawOpen", {"jawOpen": 1.0})):
        write_obj(folder / f"{name}.obj", head_template.with_vertices(head.evaluate(actions=actions)))
    line = ("rig", folder / "neutral.obj", "--templates", folder, "--overwrite", "--out", tmp_path / "rig.glb")
    result = run(*line)
    assert result.exit_code == 0 and "no eyes and no neck are put in: --model" in result.stderr
    bare = read_rig(tmp_path / "rig.npz")
    result = run(*line, "--model", model_path("pca"))
    assert result.exit_code == 0 and "no eyes" not in result.stderr
    whole = read_rig(tmp_path / "rig.npz")
    assert len(bare.neutral) == 4200 and Material.EYE in whole.triangle_materials
    misused = run("rig", folder / "neutral.obj", "--model", "pca", "--out", tmp_path / "other.glb")
    assert misused.exit_code == 2 and "--model is for an own mesh" in misused.stderr


def test_a_head_in_centimetres_is_told(run, scans, target, undrawn, tmp_path):
    mesh = read_obj(target)
    large = 100 * 0.23 / mesh.height
    write_obj(target, mesh.with_vertices(large * mesh.vertices))
    result = run("rig", target, "--templates", scans, "--out", tmp_path / "rig.glb")
    assert result.exit_code == 0 and "scan.obj: 23 m high, as a head in centimetres: expected metres" in result.stderr


def test_the_same_seed_gives_the_same_bytes(run, scans, target, tmp_path):
    for name in ("a", "b"):
        assert run("rig", target, "--templates", scans, "--out", tmp_path / f"{name}.glb").exit_code == 0
    for suffix in (".glb", ".npz", ".json", ".png"):
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_the_seed_paints_the_eyes(run, rigged, face, undrawn, tmp_path):
    again = tmp_path / "again.glb"
    assert run("rig", face, "--out", again).exit_code == 0
    for suffix in (".glb", ".npz", ".json"):
        assert again.with_suffix(suffix).read_bytes() == rigged[0].with_suffix(suffix).read_bytes()
    assert run("rig", face, "--seed", 1, "--overwrite", "--out", again).exit_code == 0
    one, other = (read_rig(path.with_suffix(".npz")) for path in (again, rigged[0]))
    assert (one.pictures.eyes != other.pictures.eyes).any()
    np.testing.assert_array_equal(one.deltas, other.deltas)


def test_a_picture_of_choice_and_that_beside_an_npz(run, scans, target, egg, tmp_path):
    for name, value in (("own", 40), ("other", 200)):
        write_png(tmp_path / f"{name}.png", np.full((4, 4, 3), value, np.uint8))
    mesh = read_obj(target)
    write_obj(target, mesh, texture="own.png")
    upper = tmp_path / "UPPER.OBJ"
    shutil.copy(target, upper)
    npz = target.with_suffix(".npz")
    write_face(npz, read_face(target))
    options = ("--templates", scans, "--overwrite", "--out", tmp_path / "rig.glb")
    chosen = ("--texture", tmp_path / "other.png")
    for path, extra, value in ((target, (), 40), (upper, (), 40), (npz, (), 40), (target, chosen, 200)):
        result = run("rig", path, *extra, *options)
        assert result.exit_code == 0, result.output
        np.testing.assert_array_equal(read_gltf(tmp_path / "rig.glb").pictures.skin, np.full((4, 4, 3), value))


def test_moods_are_pictures_by_name(run, refused, scans, target, tmp_path):
    for name, value in (("own", 40), ("sad", 20), ("angry", 90)):
        write_png(tmp_path / f"{name}.png", np.full((4, 4, 3), value, np.uint8))
    write_png(tmp_path / "large.png", np.full((8, 8, 3), 5, np.uint8))
    given = ("rig", target, "--templates", scans, "--out", tmp_path / "rig.glb")
    sad = ("--mood", f"sad={tmp_path / 'sad.png'}")
    worn = (*given, "--texture", tmp_path / "own.png", *sad)
    result = run(*worn, "--mood", f"very angry={tmp_path / 'angry.png'}")
    assert result.exit_code == 0, result.output
    for rig in (read_gltf(tmp_path / "rig.glb"), read_rig(tmp_path / "rig.npz")):
        assert [mood.name for mood in rig.moods] == ["sad", "very angry"]
        assert [int(mood.skin.mean()) for mood in rig.moods] == [20, 90] and rig.pictures.skin.mean() == 40
    assert "sad.png" in str(read_json(tmp_path / "rig.json")["inputs"])
    again = ("--overwrite",)
    assert "a picture of the skin beside them" in refused(*given, *sad, *again)
    assert "large.png: moods: expected pictures of the skin's shape" in refused(
        *worn, "--mood", f"big={tmp_path / 'large.png'}", *again
    )
    for text in ("sad", "=a.png", "sad="):
        assert "expected NAME=IMAGE" in run(*worn, "--mood", text, *again).stderr
    assert "expected NAME=IMAGE" in run(*worn, *sad, *again).stderr


def test_usd_beside_it(run, scans, target, tmp_path):
    pytest.importorskip("pxr")
    assert run("rig", target, "--templates", scans, "--usd", "--out", tmp_path / "rig.glb").exit_code == 0
    assert (tmp_path / "rig.usdz").stat().st_size > 1000


def test_without_its_package_usd_is_refused_before_any_work(refused, target, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    monkeypatch.setattr("caricli.commands.rig.read_face", lambda _: pytest.fail("read a face"))
    message = refused("rig", target, "--usd", "--out", tmp_path / "rig.glb")
    assert "rig.usdz: USD needs a package: pip install 'caricli[usd]'" in message


@pytest.fixture(scope="module")
def laughing(head, face):
    """An OBJ of the same caricature, laughing."""
    laugh = {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "jawOpen": 0.4}
    path = face.with_name("laughing.obj")
    vertices = head.evaluate(gender=0.1, age=0.8, weight=0.7, actions=laugh) * WIDE
    write_obj(path, Mesh(vertices, head.polygons, head.uvs, head.uv_polygons))
    return path


def test_a_face_that_laughs_comes_to_rest_first(run, laughing, face, head_template, undrawn, tmp_path):
    lips = [head_template.annotation.curves[f"mouth_inner_{lip}"] for lip in ("upper", "lower")]
    gaps = {}
    for choice in ("auto", "as-is"):
        out = tmp_path / f"{choice}.glb"
        result = run("rig", laughing, "--neutral", choice, "--parts", "skin", "--out", out)
        assert result.exit_code == 0, result.output
        neutral = read_rig(out.with_suffix(".npz")).neutral
        gaps[choice] = curve_gap(neutral[:, :2], *lips)
        report = read_json(out.with_suffix(".json"))["neutral"]
        if choice == "as-is":
            np.testing.assert_allclose(neutral, read_obj(laughing).vertices, atol=1e-6)
            assert "its lips are apart" in result.stderr and "without --neutral as-is" in result.stderr
            assert report == {"moved": 0.0} and "neutral as given" in result.stdout
        else:
            assert result.stderr == "" and "mm from the given one" in result.stdout
            assert report["expression_shown"] > 1 and 0.005 < report["moved"] < 0.05
    rest = read_obj(face).vertices
    assert gaps["auto"] < 1.5 * curve_gap(rest[:, :2], *lips) < 0.4 * gaps["as-is"]


def test_what_closes_the_lips_of_ones_own_mesh_is_said(capsys):
    rest = SimpleNamespace(shown=None, mesh=SimpleNamespace(height=0.23))
    _advise("scan.obj", SimpleNamespace(measures=SimpleNamespace(lips_open=0.5)), rest, "auto")
    assert "caricli blendshapes closes them with a --model" in capsys.readouterr().err


def test_wrong_usage(run, refused, face, tmp_path):
    out = tmp_path / "a.glb"
    for options in ((), (face,), ("--out", out), (face, "--out", out, "--subdivide", 9)):
        result = run("rig", *options)
        assert result.exit_code == 2 and result.stdout == "", options
    assert ".glb" in refused("rig", face, "--out", tmp_path / "a.obj", code=2)
    assert list(tmp_path.iterdir()) == []


def test_what_exists_is_kept(refused, scans, target, tmp_path):
    (tmp_path / "rig.json").write_text("mine")
    said = refused("rig", target, "--templates", scans, "--out", tmp_path / "rig.glb")
    assert "rig.json" in said and (tmp_path / "rig.json").read_text() == "mine"
    write_png(tmp_path / "rig.png", np.zeros((4, 4, 3), np.uint8))
    write_obj(target, read_obj(target), texture="rig.png")
    assert "rig.png" in refused("rig", target, "--templates", scans, "--overwrite", "--out", tmp_path / "rig.glb")


class TestRefused:
    """One line that names the file, exit 1, no output."""

    @pytest.fixture
    def check(self, refused, scans, target, tmp_path):
        def check(*words, face=target, options=("--templates", scans)):
            said = refused("rig", face, *options, "--out", tmp_path / "new" / "rig.glb")
            assert all(word in said for word in words), said
            assert not (tmp_path / "new").exists()

        return check

    def test_faces(self, check, scans, target, ball, tmp_path):
        check("none.obj", face=tmp_path / "none.obj")
        check("scan.obj", "topology of the templates (4200 vertices, 8356 triangles)", "--templates", options=())
        write_obj(tmp_path / "ball.obj", Mesh(*ball))
        check("ball.obj", "topology of the templates", "found another (300 vertices", face=tmp_path / "ball.obj")
        mesh = read_obj(target)
        mesh.vertices[mesh.polygons[40, 1]] = mesh.vertices[mesh.polygons[40, 0]]
        write_obj(tmp_path / "flat.obj", mesh)
        check("flat.obj", "expected triangles with an area", face=tmp_path / "flat.obj")
        (tmp_path / "nan.obj").write_text(target.read_text().replace("v ", "v nan ", 1))
        check("nan.obj", face=tmp_path / "nan.obj")

    def test_folders(self, check, scans, tmp_path):
        check("no: expected a folder", options=("--templates", tmp_path / "no"))
        check("scan.obj: expected a folder", options=("--templates", tmp_path / "scan.obj"))
        (tmp_path / "empty").mkdir()
        check("empty: expected neutral.obj and expressions", options=("--templates", tmp_path / "empty"))
        shutil.copy(scans / "Neutral.obj", tmp_path / "empty")
        check("empty: expected neutral.obj and expressions", options=("--templates", tmp_path / "empty"))
        (tmp_path / "empty" / "Neutral.obj").rename(tmp_path / "empty" / "Smile.obj")
        shutil.copy(scans / "Neutral.obj", tmp_path / "empty" / "Grin.obj")
        check("empty: expected neutral.obj and expressions", options=("--templates", tmp_path / "empty"))
        shutil.copy(scans / "Grin.obj", scans / "grin.OBJ")
        check("expressions: expected distinct names", "'grin' twice")

    def test_templates_of_other_meshes(self, check, scans, ball):
        mesh = read_obj(scans / "Grin.obj")
        write_obj(scans / "Grin.obj", Mesh(*ball))
        check("Grin.obj: expected the mesh of neutral.obj", "300 vertices")
        write_obj(scans / "Grin.obj", Mesh(mesh.vertices, np.roll(mesh.polygons, 1, axis=0)))
        check("Grin.obj: expected the mesh of neutral.obj")
        (scans / "Grin.obj").write_text("v 1 2\n")
        check("Grin.obj")

    def test_neutrals_that_nothing_can_be_transferred_from(self, check, scans, target):
        meshes = {path: read_obj(path) for path in (target, *scans.iterdir())}

        def rewrite(change):
            for path, mesh in meshes.items():
                write_obj(path, change(mesh))

        extra = np.array([[0, 1, 200, -1]])
        rewrite(lambda mesh: Mesh(mesh.vertices, np.vstack([mesh.polygons, extra])))
        check("Neutral.obj: expected at most two triangles on every edge, found 3")
        rewrite(lambda mesh: Mesh(np.vstack([mesh.vertices, [[1, 2, 3]]]), mesh.polygons))
        check("Neutral.obj: expected every vertex in a triangle, found 1 without")
        rewrite(lambda mesh: mesh)
        mesh = read_obj(scans / "Neutral.obj")
        mesh.vertices[mesh.polygons[40, 1]] = mesh.vertices[mesh.polygons[40, 0]]
        write_obj(scans / "Neutral.obj", mesh)
        check("Neutral.obj: expected triangles with an area")

    def test_pictures(self, check, scans, target, tmp_path):
        check("none.png", options=("--templates", scans, "--texture", tmp_path / "none.png"))
        check("scan.obj: expected a PNG", options=("--templates", scans, "--texture", target))
        write_obj(target, read_obj(target), texture="none.png")
        check("none.png")
        target.with_suffix(".mtl").write_text("map_Kd ../secret.png\n")
        check("scan.mtl: expected the name of a file beside it", "secret.png")


def test_the_table_of_action_units():
    table = read_json(asset_path("facs.json"))
    assert sorted(table) == sorted(ARKIT_NAMES)
    names = [row["facs46"] for row in table.values() if row["facs46"] is not None]
    assert len(names) == len(set(names)) == 46 and all(names)
    for name, row in table.items():
        assert set(row) == {"action_units", "facs46"}, name
        assert all(re.fullmatch(r"AU\d+", unit) for unit in row["action_units"]), name
        assert len(set(row["action_units"])) == len(row["action_units"]), name
        other = name.replace("Left", "#").replace("Right", "Left").replace("#", "Right")
        assert name == other or (row["facs46"] is None) == (table[other]["facs46"] is None), name


@pytest.mark.parametrize("options", [("--texture",), ("--mood", "sad")])
def test_a_picture_for_a_face_without_uvs_is_refused(refused, head_template, tmp_path, options):
    write_obj(tmp_path / "bare.obj", Mesh(head_template.vertices, head_template.polygons))
    write_png(tmp_path / "skin.png", np.zeros((4, 4, 3), np.uint8))
    *words, last = options
    given = [*words, f"{last}={tmp_path / 'skin.png'}"]
    told = refused("rig", tmp_path / "bare.obj", *given, "--out", tmp_path / "rig.glb")
    assert "bare.obj: expected a face with UVs for its picture, found one without" in told
    assert not (tmp_path / "rig.glb").exists()
