import struct
import zlib
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
import pytest
import trimesh
from PIL import Image

from caricli.io.checkpoint import write_checkpoint
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image, write_png
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.parsing import write_parsing
from caricli.io.rig import read_rig
from caricli.io.strict_json import read_json, write_json
from caricli.methods.dynamic.chart_pictures import ChartGrid, texture_to_chart
from caricli.methods.texture.settings import TextureSettings
from caricli.models.checkpoint import model_to_checkpoint
from caricli.models.pca.model import PcaModel
from caricli.render.visibility.rasterise import rasterise
from caricli.store.rig_sources import PictureSources, picture_sources
from caricli.structures import Camera, Face, Material, Pictures, Rig
from caricli.template.annotation import parse_annotation
from caricli.template.chart import face_chart
from tests.drawn_albedo import soft_skin
from tests.painted_moods import write_brightener
from tests.textured_pictures import render_textured

COMMAND = "texture"
NAMES = [
    "bust.png",
    "eyes.png",
    "face.glb",
    "face.json",
    "face.mtl",
    "face.npz",
    "face.obj",
    "sheet.png",
    "texture.png",
]
SIDE = 300
MAGENTA = np.array([255.0, 0, 255])
CAMERA = Camera(1050.0, np.diag([1.0, -1, -1]), np.array([150.0, 290.0]))
QUICK = ("--size", 96, "--hair", "none")


@pytest.fixture(scope="module", autouse=True)
def small_pictures():
    """Small views and eyes, which otherwise are much of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.commands.texture.SIZE", 48)
        patch.setattr("caricli.methods.texture.eye_picture.TEXTURE", 64)
        yield


@pytest.fixture(scope="module")
def scene(head, head_template, tmp_path_factory):
    """A folder with a painted head's face.npz, its picture in front of magenta, and the mask of the head."""
    folder, vertices = tmp_path_factory.mktemp("scene"), head.evaluate(gender=0.3, age=0.6)
    marks = CAMERA.project(vertices[head_template.annotation.landmarks[:68]])
    mesh = head_template.with_vertices(vertices)
    write_face(folder / "face.npz", Face(mesh, CAMERA, marks))
    skin = soft_skin(head_template)
    still = np.zeros((0, *vertices.shape), np.float32)
    rig = Rig((), mesh.with_vertices(vertices.astype(np.float32)), still, pictures=Pictures(skin))
    write_png(folder / "photo.png", render_textured(rig, CAMERA.place(vertices), SIDE, SIDE, paper=MAGENTA))
    mask = rasterise(CAMERA.place(vertices), head_template.faces, SIDE, SIDE).face >= 0
    write_png(folder / "mask.png", np.repeat(mask[..., None] * np.uint8(255), 3, axis=2))
    return folder


def inputs(scene):
    return scene / "face.npz", scene / "photo.png", "--mask", scene / "mask.png"


@pytest.fixture(scope="module")
def textured(run, scene, tmp_path_factory):
    out = tmp_path_factory.mktemp("textured") / "out"
    result = run(COMMAND, *inputs(scene), "--size", 256, "--hair", "none", "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: ") and "photometric error" in result.stdout
    return out


def test_the_folder_and_its_report(textured, scene):
    assert sorted(path.name for path in textured.iterdir()) == NAMES
    report = read_json(textured / "face.json")
    assert report["command"] == COMMAND and report["size"] == 256 and report["project_uv"] is False
    assert len(report["inputs"]) == 3 and report["seed"] == 0
    assert 0 < report["photometric_error"] < 0.03 and 0.1 < report["seen"] < 0.6
    mask = read_image(scene / "mask.png")[..., 0] > 0
    assert report["head"] == pytest.approx(mask.mean())
    assert read_image(textured / "texture.png").shape == (256, 256, 3)
    sheet = read_image(textured / "sheet.png")
    assert sheet.std() > 20 and sheet.shape[0] > 2 * 48


def test_no_background_and_the_colours_of_the_picture(textured, scene):
    texture = read_image(textured / "texture.png").astype(float)
    assert np.abs(texture - MAGENTA).sum(-1).min() > 150
    face = read_face(textured / "face.npz")
    mesh = face.mesh.with_vertices(face.vertices.astype(np.float32))
    rig = Rig((), mesh, np.zeros((0, 4200, 3), np.float32), pictures=Pictures(read_image(textured / "texture.png")))
    again = render_textured(rig, CAMERA.place(face.vertices), SIDE, SIDE).astype(float)
    mask = read_image(scene / "mask.png")[..., 0] > 0
    error = np.abs(again - read_image(scene / "photo.png"))[mask].mean() / 255
    assert error == pytest.approx(read_json(textured / "face.json")["photometric_error"], abs=1e-3)


def test_trimesh_opens_the_obj_with_its_picture(textured, scene):
    mesh = trimesh.load(textured / "face.obj", process=False)
    given = read_face(scene / "face.npz")
    assert len(mesh.faces) == len(given.faces)
    assert set(map(tuple, np.round(mesh.vertices, 5))) == set(map(tuple, np.round(given.vertices, 5)))
    image = np.asarray(mesh.visual.material.image.convert("RGB"))
    np.testing.assert_array_equal(image, read_image(textured / "texture.png"))
    assert mesh.visual.uv.min() >= 0 and mesh.visual.uv.max() <= 1
    own = read_obj(textured / "face.obj")
    np.testing.assert_array_equal(own.uv_polygons, given.mesh.uv_polygons)


def test_the_glb_has_skin_and_eyes(textured, run):
    rig = read_gltf(textured / "face.glb")
    assert (
        rig.names == ()
        and set(rig.materials) == {*Material} - {Material.HAIR, Material.CLOTH}
        and len(rig.neutral) > 4200
    )
    np.testing.assert_array_equal(rig.pictures.skin, read_image(textured / "texture.png"))
    np.testing.assert_array_equal(rig.pictures.eyes, read_image(textured / "eyes.png"))
    np.testing.assert_allclose(rig.neutral[:4200], read_face(textured / "face.npz").vertices, atol=1e-6)
    said = run("inspect", textured / "face.glb")
    assert said.exit_code == 0 and "0 shapes" in said.stdout and "ARKit" not in said.stdout


def test_a_head_of_what_is_chosen(run, scene, tmp_path):
    choice = ("--parts", "skin,teeth", "--bust", "--teeth", "cartoon")
    result = run(COMMAND, *inputs(scene), *QUICK, *choice, "--no-picture", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    rig = read_gltf(tmp_path / "out" / "face.glb")
    assert {*rig.materials} == {Material.SKIN, Material.TEETH, Material.GUMS, Material.BUST, Material.CLOTH}
    # What is left out is painted nevertheless, and `rig` puts it in again.
    assert {path.name for path in (tmp_path / "out").iterdir()} == {*NAMES} - {"sheet.png"}
    assert read_face(tmp_path / "out" / "face.npz").pictures.eyes is not None


def test_rig_takes_both_pictures_along(run, textured, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "caricli.render.sheets.expression_sheet.expression_sheet",
        lambda rig, progress, given: np.zeros((4, 4, 3), np.uint8),
    )
    result = run("rig", textured / "face.npz", "--out", tmp_path / "rig.glb")
    assert result.exit_code == 0, result.output
    rig = read_rig(tmp_path / "rig.npz")
    assert len(rig.names) == 52
    np.testing.assert_array_equal(rig.pictures.skin, read_image(textured / "texture.png"))
    np.testing.assert_array_equal(rig.pictures.eyes, read_image(textured / "eyes.png"))


def test_pictures_of_a_face(textured, tmp_path):
    expected = PictureSources(*(textured / name for name in ("texture.png", "eyes.png")), bust=textured / "bust.png")
    assert picture_sources(textured / "face.npz") == picture_sources(textured / "face.obj") == expected
    other = PictureSources(tmp_path / "other.png", textured / "eyes.png")
    assert picture_sources(textured / "face.npz", tmp_path / "other.png") == other
    assert picture_sources(tmp_path / "none.npz") == PictureSources()


@pytest.fixture(scope="module")
def quick(run, scene, tmp_path_factory):
    """A coarse texture."""
    out = tmp_path_factory.mktemp("quick") / "out"
    assert run(COMMAND, *inputs(scene), *QUICK, "--out", out).exit_code == 0
    return out


def test_the_same_input_gives_the_same_bytes(run, scene, quick, tmp_path):
    assert run(COMMAND, *inputs(scene), *QUICK, "--out", tmp_path / "out").exit_code == 0
    for name in NAMES:
        if name != "face.json":
            assert (quick / name).read_bytes() == (tmp_path / "out" / name).read_bytes(), name


def test_the_face_in_a_chart_of_its_own(run, scene, quick, tmp_path, head_template):
    out = tmp_path / "out"
    result = run(COMMAND, *inputs(scene), *QUICK, "--uv", "arap", "--out", out)
    assert result.exit_code == 0, result.output
    charted = {"face-arap.mtl", "face-arap.npz", "face-arap.obj", "texture-arap.png"}
    assert {path.name for path in out.iterdir()} == {*NAMES, *charted}
    for name in ("texture.png", "face.obj", "face.npz"):
        assert (out / name).read_bytes() == (quick / name).read_bytes()
    face = read_face(out / "face-arap.npz")
    picture = read_image(out / "texture-arap.png")
    chart = face_chart(head_template)
    np.testing.assert_array_equal(face.pictures.skin, picture)
    np.testing.assert_allclose(face.vertices, read_face(out / "face.npz").vertices[chart.vertices], atol=1e-6)
    assert read_obj(out / "face-arap.obj").same_layout(face.mesh)
    # The same texel of both pictures shows the same place of the face.
    grid = ChartGrid(chart, len(picture))
    skin = grid.covered & ~grid.mouth
    expected = texture_to_chart(read_image(out / "texture.png"), head_template, grid)
    np.testing.assert_array_equal(picture[skin], expected[skin])


def test_a_chart_needs_the_region_of_the_face(refused, scene, tmp_path, head_template):
    note = {"ibug68": head_template.annotation.landmarks[:68].tolist()}
    own = replace(head_template, annotation=parse_annotation(note, len(head_template.vertices), "own"))
    basis = np.random.default_rng(1).normal(0, 0.004, (4, len(own.vertices), 3))
    path = tmp_path / "own.safetensors"
    write_checkpoint(path, *model_to_checkpoint(PcaModel(own, own.vertices, basis), {}))
    said = refused(COMMAND, *inputs(scene), *QUICK, "--uv", "arap", "--model", path, "--out", tmp_path / "out")
    assert f"{path}: a chart of the face needs 'regions.face'" in said and not (tmp_path / "out").exists()


def test_without_a_mask_the_head_is_cut_out(run, scene, tmp_path):
    result = run(COMMAND, *inputs(scene)[:2], *QUICK, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    head = (read_image(scene / "mask.png")[..., 0] > 0).mean()
    assert read_json(tmp_path / "out" / "face.json")["head"] == pytest.approx(head, rel=0.15)
    assert np.abs(read_image(tmp_path / "out" / "texture.png") - MAGENTA).sum(-1).min() > 100


def test_the_plain_variant_has_the_picture_itself(run, scene, tmp_path):
    out = tmp_path / "out"
    result = run(COMMAND, *inputs(scene), "--hair", "none", "--project-uv", "--out", out)
    assert result.exit_code == 0, result.output
    report, mesh = read_json(out / "face.json"), read_obj(out / "face.obj")
    assert report["project_uv"] is True and report["photometric_error"] < 0.03 and report["size"] == SIDE
    mask, photo = read_image(scene / "mask.png")[..., 0] > 0, read_image(scene / "photo.png")
    np.testing.assert_array_equal(read_image(out / "texture.png")[mask], photo[mask])
    wanted = (CAMERA.project(mesh.vertices) + 0.5) / SIDE
    np.testing.assert_array_equal(mesh.uv_polygons, mesh.polygons)
    np.testing.assert_allclose(mesh.uvs, np.stack([wanted[:, 0], 1 - wanted[:, 1]], axis=1), atol=1e-5)


def test_without_a_size_it_is_as_fine_as_the_picture(run, scene, tmp_path, monkeypatch):
    monkeypatch.setattr("caricli.commands.texture.TextureSettings", partial(TextureSettings, smallest=64))
    out = tmp_path / "out"
    assert run(COMMAND, *inputs(scene), "--hair", "none", "--out", out).exit_code == 0
    side = read_json(out / "face.json")["size"]
    assert 64 < side < 2048 and read_image(out / "texture.png").shape == (side, side, 3)


def saved(image, path, mode):
    if mode == "16-bit":
        grey = np.asarray(image.convert("L"), np.uint16) * 257
        Image.fromarray(grey).save(path, "PNG")
    elif mode == "alpha":
        image.putalpha(255)
        image.save(path, "PNG")
    elif mode == "EXIF":
        exif = Image.Exif()
        exif[0x0112] = 6
        image.rotate(90, expand=True).save(path, "PNG", exif=exif)
    else:
        image.convert(mode).save(path, "TIFF")


@pytest.mark.parametrize("mode", ["alpha", "CMYK", "16-bit", "L", "EXIF"])
def test_pictures_of_other_kinds(mode, run, scene, quick, tmp_path):
    saved(Image.open(scene / "photo.png").convert("RGB"), tmp_path / "photo", mode)
    result = run(COMMAND, scene / "face.npz", tmp_path / "photo", *inputs(scene)[2:], *QUICK, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    texture, plain = (read_image(folder / "texture.png").astype(int) for folder in (tmp_path / "out", quick))
    if mode in ("alpha", "EXIF"):
        np.testing.assert_array_equal(texture, plain)
    elif mode == "CMYK":
        assert np.abs(texture - plain).max() <= 3
    else:
        assert (np.ptp(texture, axis=2) == 0).all()
        assert np.abs(texture[..., 0] - plain @ [0.299, 0.587, 0.114]).mean() < 3


def bomb():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("role", ["picture", "mask"])
@pytest.mark.parametrize("content", [bomb(), b"", b"hello"])
def test_files_that_are_no_pictures(role, content, refused, scene, tmp_path):
    (tmp_path / "bad.png").write_bytes(content)
    face, photo, flag, _ = inputs(scene)
    given = (face, tmp_path / "bad.png") if role == "picture" else (face, photo, flag, tmp_path / "bad.png")
    said = refused(COMMAND, *given, "--out", tmp_path / "out")
    assert "bad.png: expected" in said and not (tmp_path / "out").exists()


def test_masks_that_do_not_fit(refused, scene, tmp_path):
    face, photo, flag, mask = inputs(scene)
    white = read_image(mask)
    elsewhere = np.zeros_like(white)
    elsewhere[:4, :4] = 255
    cases = {
        "small": (white[:-1], "expected the picture's size, 300 x 300, found 300 x 299"),
        "black": (0 * white, "expected a mask that is white where the head is, found none there"),
        "elsewhere": (elsewhere, "expected a mask that is white where the head is, found none there"),
    }
    for name, (image, words) in cases.items():
        path = tmp_path / f"{name}.png"
        write_png(path, image)
        said = refused(COMMAND, face, photo, flag, path, "--out", tmp_path / "out")
        assert f"{path}: {words}" in said and not (tmp_path / "out").exists()


def write_labels(path, labels, names=None):
    """A label map, with a legend where its labels have names."""
    write_parsing(path, labels)
    if names is not None:
        write_json(path.with_suffix(".json"), {"schema": "caricli.parsing/1", "labels": names})
    return path


def test_a_picture_that_shows_a_face_elsewhere_is_refused_unless_it_is_told_where_the_head_is(
    run, refused, scene, tmp_path, monkeypatch
):
    monkeypatch.setattr("caricli.methods.detect.parse_face.GivenFace.elsewhere", True)
    face, photo, *mask = inputs(scene)
    options = ("--size", 64, "--hair", "none", "--no-picture", "--out", tmp_path / "out")
    said = refused(COMMAND, face, photo, *options)
    assert f"{photo}: expected the picture that the face was fitted to, found a face in another place" in said
    assert not (tmp_path / "out").exists()
    assert run(COMMAND, face, photo, *mask, *options).exit_code == 0


def test_a_label_map_stands_in_for_the_detector(run, scene, tmp_path, monkeypatch):
    monkeypatch.setattr("caricli.store.face_pictures.FaceReader.given", None)  # calling it would fail
    face, photo, _, mask = inputs(scene)
    head = read_image(mask)[..., 0] > 0
    labels = write_labels(tmp_path / "labels.png", head.astype(np.uint8))
    result = run(COMMAND, face, photo, "--parsing", labels, "--size", 64, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert f"{labels}: nothing names its labels, which are read as numbered in CelebAMask-HQ" in result.stderr
    report = read_json(tmp_path / "out" / "face.json")
    assert report["head"] == pytest.approx(head.mean(), rel=0.05) and report["hair"] is None


def test_label_maps_that_do_not_fit(refused, scene, tmp_path):
    face, photo, flag, mask = inputs(scene)
    head = (read_image(mask)[..., 0] > 0).astype(np.uint8)
    cases = {
        "small": (head[:-1], None, "expected the picture's size, 300 x 300, found 300 x 299"),
        "number": (50 * head, None, "expected numbers that the legend names, found 50"),
        "name": (head, {"wall": 0, "antler": 1}, "expected labels such as hair or skin, found 'wall'"),
        "empty": (0 * head, None, "expected pixels that show a head, found background alone"),
    }
    for name, (labels, names, words) in cases.items():
        path = write_labels(tmp_path / f"{name}.png", labels, names)
        said = refused(COMMAND, face, photo, "--parsing", path, "--out", tmp_path / "out")
        assert f"{path}: {words}" in said and not (tmp_path / "out").exists()
    ways = {flag: mask, "--parsing": path, "--detector": tmp_path}
    for first, second in combinations(ways.items(), 2):
        said = refused(COMMAND, face, photo, *first, *second, "--out", tmp_path / "out", code=2)
        assert "--mask, --parsing and --detector all say where the head is" in said


@pytest.mark.parametrize("share", [0.0, 0.02])
def test_it_is_said_where_a_face_was_edited_after_it_was_fitted(share, run, scene, tmp_path, head_template):
    face = read_face(scene / "face.npz")
    vertices = face.vertices.copy()
    diagonal = np.linalg.norm(np.ptp(face.landmarks, axis=0)) / CAMERA.scale
    vertices[head_template.annotation.landmarks[30]] += [share * diagonal, 0, 0]
    write_face(tmp_path / "face.npz", face.with_vertices(vertices))
    (_, photo, *more) = inputs(scene)
    result = run(COMMAND, tmp_path / "face.npz", photo, *more, *QUICK, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    words = "face.npz: was edited after it was fitted: landmarks are up to 2.0 % of their diagonal away"
    assert (words in result.stderr) == bool(share) and ("edited" in result.stderr) == bool(share)


def test_another_picture(refused, scene, tmp_path):
    face = read_face(scene / "face.npz")
    write_face(
        tmp_path / "away.npz", replace(face, camera=replace(face.camera, translation=face.camera.translation + 5000))
    )
    said = refused(COMMAND, tmp_path / "away.npz", scene / "photo.png", "--out", tmp_path / "out")
    assert "photo.png: expected the picture that the face was fitted to" in said and not (tmp_path / "out").exists()


@pytest.mark.parametrize("kind", ["OBJ", "NPZ", "landmarks"])
def test_a_face_that_was_fitted_to_no_picture(kind, refused, scene, tmp_path):
    face = read_face(scene / "face.npz")
    path = tmp_path / ("bare.obj" if kind == "OBJ" else "bare.npz")
    if kind == "OBJ":
        write_obj(path, face.mesh)
    elif kind == "NPZ":
        write_face(path, replace(face, camera=None))
    else:
        write_face(path, replace(face, landmarks=None))
    said = refused(COMMAND, path, scene / "photo.png", "--out", tmp_path / "out")
    assert f"{path}: expected a face with " in said and "reconstruct-from-landmarks" in said
    assert not (tmp_path / "out").exists()


def test_outputs_that_exist_and_wrong_usage(refused, run, scene, textured, tmp_path):
    before = (textured / "texture.png").read_bytes()
    assert "--overwrite" in refused(COMMAND, *inputs(scene), "--out", textured)
    assert (textured / "texture.png").read_bytes() == before
    own = tmp_path / "own"
    own.mkdir()
    (own / "diary.txt").write_text("mine")
    assert "face.json" in refused(COMMAND, *inputs(scene), "--out", own, "--overwrite")
    assert "input" in refused(COMMAND, *inputs(scene), "--out", scene, "--overwrite")
    assert (own / "diary.txt").read_text() == "mine"
    for size in (63, 4097, "big"):
        result = run(COMMAND, *inputs(scene), "--size", size, "--out", tmp_path / "out")
        assert result.exit_code == 2 and "--size" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["own"]


def test_hair_of_the_picture_becomes_a_shell(run, scene, tmp_path):
    out = tmp_path / "out"
    result = run(COMMAND, *inputs(scene)[:2], "--size", 96, "--hair", "shell", "--out", out)
    assert result.exit_code == 0 and "as in the picture" in result.stdout
    face = read_face(out / "face.npz")
    assert face.hair is not None and face.pictures.hair.shape == (96, 96, 3) and (out / "hair.png").is_file()
    assert len(face.vertices) == 4200
    feet = face.hair.footing(face.vertices)
    away = np.linalg.norm(face.hair.shell.vertices - feet, axis=1)
    assert 0.002 < np.median(away) < 0.05
    report = read_json(out / "face.json")["hair"]
    assert report["overlap"] > 0.8 and 0 <= report["doubt"] < 0.3


@pytest.fixture(scope="module")
def network(head_template, tmp_path_factory):
    return write_brightener(tmp_path_factory.mktemp("network") / "n.safetensors", head_template.topology_id)


def test_the_skin_in_expressions(run, scene, quick, network, tmp_path):
    (tmp_path / "set.yaml").write_text("neutral: {}\nopen mouth: {jawOpen: 0.8}\n")
    chosen = ("--expressions", tmp_path / "set.yaml", "--texture-network", network)
    result = run(COMMAND, *inputs(scene), *QUICK, *chosen, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == sorted([*NAMES, "texture-neutral.png", "texture-open mouth.png"])
    usual = read_image(tmp_path / "out" / "texture.png")
    np.testing.assert_array_equal(usual, read_image(quick / "texture.png"))
    for name in ("neutral", "open mouth"):
        picture = read_image(tmp_path / "out" / f"texture-{name}.png")
        assert picture.shape == usual.shape and (picture != usual).any()
    assert str(network) in read_json(tmp_path / "out" / "face.json")["inputs"]


def test_expressions_that_cannot_be_painted_are_told_before_anything_is(refused, scene, network, tmp_path, monkeypatch):
    monkeypatch.setattr("caricli.methods.texture.paint_head.paint_head", None)
    table = tmp_path / "set.yaml"
    line = (COMMAND, *inputs(scene), "--out", tmp_path / "out", "--expressions", table)
    table.write_text("neutral: {}\n../up: {jawOpen: 1}\n")
    assert "names that files can have, found '../up'" in refused(*line, "--texture-network", network)
    table.write_text("neutral: {}\narap: {jawOpen: 1}\n")
    assert "names that files can have, found 'arap'" in refused(*line, "--texture-network", network)
    table.write_text("neutral: {}\nopen: {jawOpne: 1}\n")
    assert "jawOpne" in refused(*line, "--texture-network", network)
    assert "none.safetensors" in refused(*line, "--texture-network", tmp_path / "none.safetensors")
    refused(*line[:-2], "--texture-network", network, code=2)
    assert not (tmp_path / "out").exists()


def test_a_chart_that_was_edited_goes_back_onto_the_head(run, refused, textured, scene, tmp_path):
    charted = run(COMMAND, *inputs(scene), "--size", 256, "--hair", "none", "--uv", "arap", "--out", tmp_path / "arap")
    assert charted.exit_code == 0, charted.output
    line = (COMMAND, tmp_path / "arap" / "face.npz", tmp_path / "edited.png", "--retouched")
    picture = read_image(tmp_path / "arap" / "texture-arap.png")
    write_png(tmp_path / "edited.png", picture)
    same = run(*line, "--out", tmp_path / "same")
    assert same.exit_code == 0 and "0.0 % of the face retouched" in same.stdout, same.output
    usual = read_image(tmp_path / "arap" / "texture.png").astype(int)
    np.testing.assert_array_equal(read_face(tmp_path / "same" / "face.npz").pictures.skin, usual)
    side = len(picture)
    spot = np.s_[side // 5 : side // 4, side * 2 // 5 : side // 2]
    picture[spot] = [20, 200, 40]
    write_png(tmp_path / "edited.png", picture)
    result = run(*line, "--out", tmp_path / "green")
    assert result.exit_code == 0 and result.stderr == "", result.output
    skin = read_face(tmp_path / "green" / "face.npz").pictures.skin
    green = (np.abs(skin.astype(int) - [20, 200, 40]) < 12).all(-1)
    assert green.sum() > 20 and ((skin != usual).any(-1) & ~green).sum() < 4 * np.sqrt(green.sum()) + 20
    others = (
        ("--uv", "arap"),
        ("--hair", "none"),
        ("--bust",),
        ("--parts", "skin"),
        ("--teeth", "cartoon"),
        ("--seed", 1),
        # What is typed as it would be anyway is typed.
        ("--hair", "auto"),
        ("--uv", "head"),
        ("--seed", 0),
        ("--no-picture",),
    )
    for others_typed in others:
        assert "no other options" in refused(*line, *others_typed, "--out", tmp_path / "none", code=2)


def test_a_picture_of_another_chart(run, refused, textured, scene, tmp_path):
    line = (COMMAND, textured / "face.npz", tmp_path / "other.png", "--retouched", "--out")
    write_png(tmp_path / "other.png", np.zeros((64, 48, 3), np.uint8))
    assert "other.png: expected a square picture in the chart" in refused(*line, tmp_path / "out")
    write_png(tmp_path / "other.png", np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8))
    result = run(*line, tmp_path / "out")
    assert result.exit_code == 0 and "is it of another chart?" in result.stderr
    assert "picture on its skin" in refused(COMMAND, scene / "face.npz", *line[2:], tmp_path / "bare")
