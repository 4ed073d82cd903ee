from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pygltflib
import pytest

from caricli.geometry.alignment.similarity import similarity
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.rig import read_rig, write_rig
from caricli.io.strict_json import read_json
from caricli.render.sheets import driver_sheet
from caricli.store.models import load_model
from caricli.structures import Face, Landmarks, Mesh, Rig

COMMAND = "retarget"
NAMES = ("jawOpen", "mouthSmileLeft", "mouthSmileRight", "browInnerUp", "eyeBlinkLeft")
TRUTH = np.array([[0.6, 0, 0, 0.9, 0], [0, 0.8, 0.7, 0, 0.5], [0.2, 0, 0, 0, 1.3]])


@pytest.fixture(autouse=True)
def small_sheets(monkeypatch):
    monkeypatch.setattr("caricli.render.sheets.driver_sheet.SIZE", 48)


@pytest.fixture(scope="module")
def deltas(head):
    return head.actions[[head.action_names.index(name) for name in NAMES]]


@pytest.fixture(scope="module")
def rig_file(ball, deltas, tmp_path_factory):
    """A ball with five expressions and what they do to a normal face."""
    vertices, faces = ball
    own = 0.02 * np.random.default_rng(4).normal(size=(5, *vertices.shape))
    path = tmp_path_factory.mktemp("rig") / "b.npz"
    made = Rig(NAMES, Mesh((0.1 * vertices).astype(np.float32), faces), own.astype(np.float32), normal_deltas=deltas)
    write_rig(path, made)
    return path


@pytest.fixture(scope="module")
def drivers(head, head_template, deltas, tmp_path_factory):
    """(neutral OBJ, three OBJ of a person in the template's size, three landmark files of the same faces)."""
    folder, marks = tmp_path_factory.mktemp("drivers"), load_model(kind="morphable").template.annotation.landmarks[:68]
    neutral, face = head.evaluate(gender=0.3, weight=0.7), head_template.region("face")
    scale, rotation, translation = similarity(neutral[face], head_template.vertices[face])
    neutral = scale * neutral @ rotation.T + translation
    meshes, files = [], []
    for number, shape in enumerate([neutral, *(neutral + np.tensordot(TRUTH, deltas.astype(float), 1))]):
        meshes.append(folder / f"mesh-{number}.obj")
        write_obj(meshes[-1], Mesh(shape, head.polygons, head.uvs, head.uv_polygons))
        points = 1400 * shape[marks, :2] * [1, -1] + [200, 320]
        files.append(folder / f"marks-{number}.json")
        write_landmarks(files[-1], Landmarks(points, (400, 400)))
    return meshes[0], meshes[1:], files[1:]


def posed(rig_file, weights):
    rig = read_rig(rig_file)
    return rig.neutral + np.tensordot(weights, rig.deltas.astype(float), 1)


def found(path):
    return np.array([read_json(path.with_suffix(".json"))["weights"][name] for name in NAMES])


def test_four_files_that_agree_with_each_other(run, rig_file, drivers, tmp_path):
    neutral, meshes, _ = drivers
    out = tmp_path / "out" / "face.obj"
    result = run(COMMAND, rig_file, meshes[0], "--neutral", neutral, "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: browInnerUp 0.9") and "jawOpen 0.6" in result.stdout
    assert sorted(path.name for path in out.parent.iterdir()) == ["face.json", "face.npz", "face.obj", "face.png"]
    mesh, face, report = read_obj(out), read_face(out.with_suffix(".npz")), read_json(out.with_suffix(".json"))
    np.testing.assert_allclose(found(out), TRUTH[0], atol=2e-3)
    np.testing.assert_allclose(mesh.vertices, posed(rig_file, found(out)), atol=1e-6)
    np.testing.assert_allclose(face.vertices, mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(mesh.polygons, read_rig(rig_file).faces)
    assert face.latent is None and face.camera is None
    assert set(report["inputs"]) == {str(rig_file), str(meshes[0]), str(neutral)} and report["command"] == COMMAND
    assert report["left_mm"] < 0.01 and read_image(out.with_suffix(".png")).shape[1] > 96


@pytest.mark.parametrize(("own", "others"), [(100, 1000), (1000, 1), (1, 10)])
def test_meshes_of_any_unit_drive(run, rig_file, drivers, tmp_path, own, others):
    neutral, meshes, _ = drivers
    for path, size in ((neutral, own), (meshes[0], others)):
        mesh = read_obj(path)
        write_obj(tmp_path / path.name, mesh.with_vertices(size * mesh.vertices))
    out = tmp_path / "face.obj"
    calm = ("--neutral", tmp_path / neutral.name)
    result = run(COMMAND, rig_file, tmp_path / meshes[0].name, *calm, "--out", out, "--no-picture")
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(found(out), TRUTH[0], atol=2e-3)


def test_a_picture_of_that_name_is_in_nobodys_way_where_none_is_drawn(run, rig_file, drivers, tmp_path):
    (tmp_path / "face.png").write_text("mine")
    result = run(COMMAND, rig_file, drivers[1][0], "--out", tmp_path / "face.obj", "--no-picture")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "face.png").read_text() == "mine" and (tmp_path / "face.obj").exists()


def test_a_sequence_and_its_animation(run, rig_file, drivers, tmp_path):
    _, meshes, marks = drivers
    for kind, sources, unit in (("mesh", meshes, "left_mm"), ("marks", marks, "left_percent")):
        folder, glb = tmp_path / kind, tmp_path / f"{kind}.glb"
        result = run(COMMAND, rig_file, *sources, "--out-dir", folder, "--animation", glb, "--fps", 10)
        assert result.exit_code == 0, result.output
        assert f"{glb}: 3 frames at 10 a second" in result.stdout
        weights = np.array([found(folder / path.name) for path in sources])
        assert np.abs(weights - TRUTH).mean() < 0.15
        assert all(read_json(path)["drivers"] == 3 and unit in read_json(path) for path in folder.glob("*.json"))
        times, values = animated(glb)
        np.testing.assert_allclose(times, [0, 0.1, 0.2], atol=1e-6)
        np.testing.assert_allclose(values, weights, atol=1e-6)
        assert read_gltf(glb).names == NAMES
        report = read_json(glb.with_suffix(".json"))
        np.testing.assert_allclose(np.transpose([report["weights"][name] for name in NAMES]), weights, atol=1e-9)
        assert report["fps"] == 10 and len(report["inputs"]) == 4
    assert weights.max() > 0.5 and values.max() <= 1.5


def test_the_pictures_of_many_drivers_share_a_stage(run, rig_file, drivers, tmp_path, monkeypatch):
    build = Mock(wraps=driver_sheet.driver_stage)
    monkeypatch.setattr(driver_sheet, "driver_stage", build)
    assert run(COMMAND, rig_file, *drivers[2], "--out-dir", tmp_path).exit_code == 0
    assert len([*tmp_path.glob("*.png")]) == 3 and build.call_count == 1


def test_an_animation_needs_no_faces_beside_it(run, rig_file, drivers, tmp_path):
    result = run(COMMAND, rig_file, *drivers[1], "--neutral", drivers[0], "--animation", tmp_path / "a.glb")
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.glb", "a.json"]
    np.testing.assert_allclose(animated(tmp_path / "a.glb")[1], TRUTH, atol=2e-3)


def animated(path):
    """Times and weights (T, K) of the one animation of a GLB, by pygltflib."""
    gltf = pygltflib.GLTF2().load(str(path))
    (sampler,), blob = gltf.animations[0].samplers, gltf.binary_blob()

    def array(index):
        accessor = gltf.accessors[index]
        start = gltf.bufferViews[accessor.bufferView].byteOffset or 0
        return np.frombuffer(blob, "<f4", accessor.count, start)

    times = array(sampler.input)
    return times, array(sampler.output).reshape(len(times), -1)


def test_polygons_and_uvs_of_the_rig_stay(run, rig_file, drivers, tmp_path):
    rig, generator = read_rig(rig_file), np.random.default_rng(0)
    polygons = rig.faces[::-1].copy()
    mesh = Mesh(rig.neutral, polygons, generator.random((len(rig.neutral), 2)), polygons)
    mapped = replace(rig, mesh=mesh, materials=np.zeros(len(polygons), np.int32))
    write_rig(tmp_path / "b.npz", mapped)
    result = run(COMMAND, tmp_path / "b.npz", drivers[1][0], "--out", tmp_path / "f.obj")
    assert result.exit_code == 0, result.output
    for back in (read_obj(tmp_path / "f.obj"), read_face(tmp_path / "f.npz").mesh):
        np.testing.assert_array_equal(back.polygons, polygons)
        np.testing.assert_array_equal(back.uv_polygons, polygons)
        np.testing.assert_allclose(back.uvs, mesh.uvs, atol=1e-8)


def test_a_bad_driver_does_not_stop_the_others_but_ends_an_animation(run, refused, rig_file, drivers, tmp_path):
    neutral, meshes, _ = drivers
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    sources = (meshes[0], bad, meshes[1])
    result = run(COMMAND, rig_file, *sources, "--neutral", neutral, "--out-dir", tmp_path / "out")
    assert result.exit_code == 1 and "topology" in result.stderr and "1 of 3 failed" in result.stderr
    assert sorted(path.stem for path in (tmp_path / "out").glob("*.obj")) == ["mesh-1", "mesh-2"]
    place = tmp_path / "new"
    assert "topology" in refused(COMMAND, rig_file, *sources, "--out-dir", place, "--animation", place / "a.glb")
    assert not place.exists()
    result = run(COMMAND, rig_file, bad, "--out-dir", place)
    assert result.exit_code == 1 and "topology" in result.stderr and not place.exists()


def test_bad_input_is_one_line_and_leaves_nothing(refused, ball, rig_file, drivers, tmp_path):
    neutral, meshes, _ = drivers
    rig, place = read_rig(rig_file), tmp_path / "new"

    def check(*words, rig=rig_file, driver=meshes[0], options=(), code=1):
        said = refused(COMMAND, rig, driver, "--out", place / "f.obj", *options, code=code)
        assert all(word in said for word in words), said
        assert not place.exists()

    for name, changed, words in (
        ("plain", replace(rig, normal_deltas=None), ("normal face", "caricli blendshapes")),
        ("still", replace(rig, normal_deltas=0 * rig.normal_deltas), ("move a normal face",)),
        ("other", replace(rig, normal_deltas=rig.normal_deltas[:, :9]), ("4200", "found 9")),
    ):
        write_rig(tmp_path / f"{name}.npz", changed)
        check(name, *words, rig=tmp_path / f"{name}.npz")
    few = tmp_path / "few.txt"
    few.write_text("\n".join([*(f"{3 * k} {k * k}" for k in range(5)), *["null null"] * 63]))
    check("few.txt", "at least 8", driver=few)
    vertices, faces = ball
    write_obj(tmp_path / "ball.obj", Mesh(0.1 * vertices, faces))
    check("ball.obj", "topology", driver=tmp_path / "ball.obj")
    check("ball.obj", "topology", options=("--neutral", tmp_path / "ball.obj"))
    check("no such file", driver=tmp_path / "none.obj")
    check("kind morphable", options=("--model", "pca"))
    check("ends in .glb", options=("--animation", place / "a.gltf"), code=2)
    write_face(tmp_path / "face.npz", Face(Mesh(vertices, faces)))
    check("caricli.rig/1", rig=tmp_path / "face.npz")


def test_wrong_usage_is_2(run, rig_file, drivers, tmp_path):
    neutral, meshes, marks = drivers
    for sources, options in (
        (meshes[:2], ("--out", "f.obj")),
        (meshes[:1], ()),
        (marks[:1], ("--out", "f.obj", "--neutral", neutral)),
        ((meshes[0], marks[0]), ("--out-dir", "d")),
        (meshes[:1], ("--out", "f.obj", "--fps", 0)),
        (meshes[:1], ("--out", "f.obj", "--animation", "f.glb")),
    ):
        result = run(COMMAND, rig_file, *sources, *options)
        assert result.exit_code == 2 and result.stdout == "", result.output


@pytest.mark.parametrize("options", [("--parts", "skin"), ("--bust",)])
def test_a_picture_is_drawn_with_the_whole_head(options, run, rig_file, drivers, tmp_path):
    again = ("--picture", tmp_path / "drawing.png", "--out", tmp_path / "again.png")
    result = run(COMMAND, rig_file, drivers[1][0], *again, *options)
    assert result.exit_code == 2 and "--picture takes all of B.npz" in result.output


@pytest.mark.parametrize("options", [("--dynamic-texture",), ("--picture", "drawing.png")])
def test_an_animation_alone_has_no_pictures_of_its_own(options, run, rig_file, drivers, tmp_path):
    result = run(COMMAND, rig_file, drivers[1][0], "--animation", tmp_path / "take.glb", *options)
    assert result.exit_code == 2 and "not for --animation alone" in result.output


def test_outputs_are_never_inputs(refused, rig_file, drivers):
    driver = drivers[1][0]
    for out in (driver, rig_file.with_suffix(".obj")):
        assert "one of the inputs" in refused(COMMAND, rig_file, driver, "--out", out, "--overwrite")


def test_places_that_cannot_be_written_are_refused_before_the_drivers_are_read(
    refused, rig_file, drivers, tmp_path, monkeypatch
):
    def read(*_):
        raise AssertionError("nothing must be read")

    monkeypatch.setattr("caricli.store.drivers.load_drivers", read)
    (tmp_path / "file").write_text("no folder")
    (tmp_path / "a.json").write_text("mine")
    for options, expected in (
        (("--out", tmp_path / "file" / "f.obj"), "cannot be written"),
        (("--out", tmp_path / "a.obj"), "a.json exists"),
        (("--out-dir", tmp_path / "file"), "cannot be written"),
        (("--out-dir", tmp_path / "d", "--animation", tmp_path / "a.glb"), "a.json exists"),
    ):
        assert expected in refused(COMMAND, rig_file, *drivers[1][:1], *options)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "file"]
