import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from caricli.data.sketch_set import SketchWriter
from caricli.io.bundled import asset_path
from caricli.io.face import write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.meshes.mesh import write_mesh
from caricli.io.parsing import legend
from caricli.io.rig import write_rig
from caricli.io.session import write_session
from caricli.io.strict_json import read_json, write_json
from caricli.store.models import load_model
from caricli.structures import Animation, Camera, Face, Mesh, Operation, Rig, Session, Sketch, Stroke, StrokeKind, Track
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.change_atlas import ChangeAtlas
from caricli.structures.materials import Material
from caricli.structures.parsing import Region
from caricli.structures.pictures import Mood, Pictures
from tests.acted_textures import write_acted_set
from tests.drawn_pictures import mean_shape, write_drawn_set
from tests.written_weights import write_weights

COMMAND = "inspect"


@pytest.fixture
def inspect(run):
    """Lines that are said of a file, and the JSON."""

    def check(path):
        said = run(COMMAND, path)
        values = run(COMMAND, path, "--json")
        assert said.exit_code == values.exit_code == 0, said.output + values.output
        assert said.stderr == values.stderr == ""
        lines = said.stdout.splitlines()
        report = json.loads(values.stdout)
        assert lines[0].startswith(f"{path}: {report['kind']}, ") and report["file"] == str(path)
        assert (lines[-1] == "whole") == report["whole"] == (not report["problems"])
        return lines, report

    return check


@pytest.fixture(scope="module")
def rig(head, head_template):
    """The head with ARKit's expressions."""
    neutral = head_template.with_vertices(head_template.vertices.astype(np.float32))
    return Rig(head.action_names, neutral, head.actions.astype(np.float32))


def test_a_face(inspect, head_template, tmp_path):
    model = load_model(kind="pca")
    camera = Camera(1500.0, np.diag([1.0, -1, -1]), np.array([200.0, 300]))
    latent = np.zeros(len(model.prior.mean))
    face = Face(head_template, camera, np.zeros((68, 2)), latent, model_id=model.model_id)
    write_face(tmp_path / "face.npz", face)
    (tmp_path / "face.json").write_text("{}")
    lines, report = inspect(tmp_path / "face.npz")
    assert "4200 vertices" in lines[0] and "8356 triangles" in lines[0]
    for words in (
        "topology: that of the bundled models",
        "a camera of 1500 pixels a metre",
        "68 landmarks",
        f"a latent of {len(latent)} numbers of the bundled pca model",
        "beside it: face.json",
    ):
        assert words in lines
    assert report["mesh"]["known_topology"] and report["mesh"]["flipped"] == 0 and report["beside"] == ["face.json"]


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".gltf"])
def test_anybodys_mesh_and_what_is_wrong_with_it(inspect, ball, suffix, tmp_path):
    vertices, faces = ball
    path = tmp_path / f"ball{suffix}"
    write_mesh(path, Mesh(10 * vertices, faces))
    lines, report = inspect(path)
    assert "topology: not known" in lines and "19.9 m high, as a head in centimetres: expected metres" in lines
    assert report["kind"] == "mesh" and report["whole"]
    broken = faces.copy()
    broken[5] = broken[5, ::-1]
    write_mesh(path, Mesh(0.1 * vertices, broken))
    lines, report = inspect(path)
    assert lines[-1] == "not whole: 3 edges whose triangles are wound against each other" and not report["whole"]


@pytest.mark.parametrize("suffix", [".npz", ".glb"])
def test_a_rig(inspect, rig, suffix, tmp_path):
    path = tmp_path / f"rig{suffix}"
    (write_rig if suffix == ".npz" else write_gltf)(path, rig)
    lines, report = inspect(path)
    assert "52 shapes" in lines[0] and "ARKit: 52 of 52 names, 0 missing" in lines
    assert sum("eyeBlinkLeft" in line for line in lines) == 1
    assert report["arkit"]["missing"] == [] and len(report["shapes"]) == 52 and report["moods"] == []
    assert report["shapes"][0].keys() == {"name", "largest", "moved", "flipped"}


@pytest.mark.parametrize("suffix", [".npz", ".glb"])
def test_moods_of_a_rig(inspect, rig, suffix, tmp_path):
    path = tmp_path / f"rig{suffix}"
    skin = np.zeros((16, 16, 3), np.uint8)
    moods = tuple(Mood(name, skin) for name in ("sad", "very\nangry"))
    changes = ChangeAtlas(np.full((11 * 16, 10 * 16, 3), 128, np.uint8), 10, 16, (0.1, 0.1, 0.9, 0.9), 0.5, 0.5)
    worn = replace(rig, pictures=Pictures(skin), moods=moods, changes=changes)
    (write_rig if suffix == ".npz" else write_gltf)(path, worn)
    lines, report = inspect(path)
    assert "with a picture of skin, what expressions do to the picture of skin" in lines
    assert r"moods of the skin: sad, very\nangry" in lines and report["moods"] == ["sad", "very\nangry"]


@pytest.mark.parametrize("shapes", [52, 0])
def test_animations(inspect, rig, shapes, tmp_path):
    path = tmp_path / "moving.glb"
    still = Rig(rig.names[:shapes], rig.mesh, rig.deltas[:shapes])
    turns = np.tile([0.0, 0, 0, 1], (31, 1))
    write_gltf(path, still, animation=Animation(np.arange(31) / 20, np.zeros((31, shapes)), turns))
    lines, report = inspect(path)
    assert "animation 'animation': 1.5 s, 31 frames" in lines
    assert report["animations"] == [{"name": "animation", "length": 1.5, "frames": 31}]
    assert report["kind"] == ("rig" if shapes else "mesh")


def test_of_a_head_that_keeps_still_no_expression_is_missing(inspect, rig, tmp_path):
    materials = np.full(len(rig.mesh.polygons), Material.EYE, np.int32)
    write_gltf(tmp_path / "a.glb", replace(rig, names=(), deltas=rig.deltas[:0], materials=materials))
    lines, _ = inspect(tmp_path / "a.glb")
    assert "0 shapes" in lines[0] and not any("ARKit" in line or "missing" in line for line in lines)


def test_names_that_are_not_arkits(inspect, ball, tmp_path):
    vertices, faces = ball
    deltas = np.zeros((3, 300, 3), np.float32)
    deltas[:, :40, 1] = 0.01
    small = Mesh((0.1 * vertices).astype(np.float32), faces)
    write_gltf(tmp_path / "a.glb", Rig(("cheekPuff", "cheekPuff_L", "extra"), small, deltas))
    assert "cheekPuff_L: a part of cheekPuff, which is there" in inspect(tmp_path / "a.glb")[0]
    write_gltf(tmp_path / "a.glb", Rig(("jawOpen", "tongue_out", "extra"), small, deltas))
    lines, report = inspect(tmp_path / "a.glb")
    assert "tongue_out: ARKit spells it tongueOut" in lines and "extra: no ARKit name" in lines
    assert "ARKit: 1 of 52 names, 50 missing" in lines
    assert any(line.startswith("missing: eyeBlinkLeft, ") for line in lines)
    assert report["arkit"]["near"] == {"tongue_out": "tongueOut"} and len(report["arkit"]["missing"]) == 50


def test_the_skin_of_a_rig_with_eyes_is_known(inspect, run, head_template, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "caricli.render.sheets.expression_sheet.expression_sheet",
        lambda rig, progress, given: np.zeros((4, 4, 3), np.uint8),
    )
    write_mesh(tmp_path / "head.obj", head_template)
    assert run("rig", tmp_path / "head.obj", "--out", tmp_path / "rig.glb").exit_code == 0
    lines, report = inspect(tmp_path / "rig.npz")
    parts = ["skin", "eyes", "teeth", "tongue", "lashes", "bust"]
    assert "topology: that of the bundled models" in lines and f"made of {', '.join(parts)}" in lines
    assert report["mesh"]["components"] > 5 and report["parts"] == parts
    assert report["beside"] == ["rig.glb", "rig.json", "rig.png"]


@pytest.mark.parametrize("suffix", [".npz", ".glb"])
def test_the_skin_of_a_rig_is_known_where_it_comes_last(inspect, ball, head_template, suffix, tmp_path):
    eye, faces = ball
    vertices = np.vstack([0.01 * eye, head_template.vertices]).astype(np.float32)
    mesh = Mesh(vertices, np.vstack([faces, len(eye) + head_template.faces]))
    materials = np.repeat([Material.EYE, Material.SKIN], [len(faces), len(head_template.faces)])
    path = tmp_path / f"rig{suffix}"
    rig = Rig((), mesh, np.zeros((0, *vertices.shape), np.float32), materials.astype(np.int32))
    (write_rig if suffix == ".npz" else write_gltf)(path, rig)
    lines, report = inspect(path)
    assert "topology: that of the bundled models" in lines and report["mesh"]["flipped"] == 0


def test_models_maps_and_directions(inspect):
    lines, report = inspect(asset_path("pca.safetensors"))
    assert "trained with 720 people" in lines and report["people"] == 720
    assert "one of those that come with caricli" in lines and report["model_kind"] == "pca" and report["bundled"]
    _, report = inspect(asset_path("landmark_map.safetensors"))
    assert 0 < report["styles"] < 10
    lines, report = inspect(asset_path("directions-pca.npz"))
    assert lines[0].endswith("of the bundled pca model") and 0.5 < report["labels"]["BigNose"]["auc"] <= 1


@pytest.mark.parametrize("name", ["coarse", "detector", "gesture", "sketch", "style", "texture"])
def test_bundled_networks(inspect, name):
    _, report = inspect(asset_path(f"{name}.safetensors"))
    assert report["weights"] > 1e4 and len(report["model_id"]) == 64


def test_sessions(inspect, tmp_path):
    strokes = [Operation("draw", {"points": [[0, 0], [9, k]]}) for k in range(3)]
    write_session(tmp_path / "session.json", Session(None, (*strokes, Operation("clear"))))
    lines, report = inspect(tmp_path / "session.json")
    assert "begins with an empty canvas" in lines and "3 draw, 1 clear" in lines
    assert report["operations"] == 4 and report["names"] == {"draw": 3, "clear": 1}


def test_landmarks(inspect, marks):
    lines, report = inspect(marks)
    assert "ibug68, 68 of 68 points known" in lines[0] and "a picture of 400 x 400 pixels" in lines
    assert report["points"] == 68 and report["missing"] == {} and report["image_size"] == [400, 400]


def test_missing_landmarks_are_counted_by_part(inspect, points, tmp_path):
    rows = ["null null" if k in (3, 50, 51) else f"{x} {y}" for k, (x, y) in enumerate(points[:68])]
    (tmp_path / "marks.txt").write_text("\n".join(rows))
    lines, report = inspect(tmp_path / "marks.txt")
    assert "not known: 1 of jaw, 2 of mouth" in lines and report["missing"] == {"jaw": 1, "mouth": 2}


def test_weights(inspect, tmp_path):
    weights = np.zeros((3, 3))
    weights[:, 0] = [0, 0.5, 1.2]
    head = np.zeros((3, 3))
    write_weights(tmp_path / "take.json", Track((*ARKIT_NAMES[:2], "grin"), np.arange(3) / 10, weights, head))
    lines, report = inspect(tmp_path / "take.json")
    assert "3 frames, 0.2 s, 3 names" in lines[0] and "ARKit: 2 of 52 names, others: grin" in lines
    assert "weights from 0 to 1.2" in lines and "the head turns" in lines
    assert f"always 0: {ARKIT_NAMES[1]}, grin" in lines and report["frames"] == 3


def test_names_of_anybody_stay_on_their_line(inspect, tmp_path):
    write_weights(tmp_path / "take.json", Track(("whole\n\x1b[2J",), np.arange(2) / 10, np.ones((2, 1))))
    lines, report = inspect(tmp_path / "take.json")
    assert r"others: whole\n\x1b[2J" in lines[1] and len(lines) == 5
    assert report["names"] == ["whole\n\x1b[2J"]


def test_a_dataset(inspect, dataset):
    lines, report = inspect(dataset)
    assert lines[0].startswith(f"{dataset}: dataset, 16 meshes of 4 people, 4200 vertices")
    assert report["meshes"] == 16 and sum(report["splits"].values()) == 16 and report["flipped_worst"] < 0.05
    assert inspect(dataset / "dataset.json")[1]["meshes"] == 16


def test_files_of_a_dataset(inspect, dataset):
    lines, report = inspect(dataset / "shard-0000.npz")
    assert lines[0].endswith("a part of a dataset, 16 meshes") and report["meshes"] == 16
    assert lines[1].startswith("holds: ") and "vertices, identity" in lines[1] and "level" in lines[1]
    for name, words in (("labels", " labels"), ("template", "4200 vertices")):
        assert inspect(dataset / f"{name}.npz")[0][0].endswith(words)


def test_folders_of_pictures(inspect, refused, head_template, tmp_path):
    folder = write_drawn_set(tmp_path / "set", mean_shape(head_template), 8, 0)
    for path in (folder, folder / "pictures.json"):
        lines, report = inspect(path)
        assert lines[0].endswith("pictures, 8 pictures, 8 faces of 3 people") and "made as: 8 flat" in lines
        assert report["pictures"] == report["faces"] == 8
    assert inspect(folder / "truth.npz")[0][0].endswith("a part of pictures, 8 faces")
    assert inspect(folder)[0][-1] == "whole"
    picture = folder / "pictures" / "000002.jpg"
    before = picture.read_bytes()
    shutil.copy(folder / "pictures" / "000001.jpg", picture)
    assert inspect(folder)[0][-1] == "not whole: pictures changed since they were written"
    # Folders of before say nothing of their pictures.
    manifest = read_json(folder / "pictures.json")
    write_json(folder / "pictures.json", {name: value for name, value in manifest.items() if name != "sha256"})
    assert inspect(folder)[0][-1] == "whole"
    write_json(folder / "pictures.json", manifest)
    picture.write_bytes(before)
    (folder / "labels" / "000003.png").unlink()
    assert inspect(folder)[0][-1] == "not whole: 1 pictures missing"
    (folder / "truth.npz").write_bytes(b"PK")
    assert "the file was changed" in refused(COMMAND, folder)


def test_folders_of_sketches(inspect, head_template, tmp_path):
    writer = SketchWriter(tmp_path / "set", ("nose",))
    truth = {"row": 1, "person": 0, "expression": 2, "level": 1, "scale": 2.0, "translation": np.ones(2)}
    for _ in range(3):
        sketch = Sketch((Stroke(np.array([[1.0, 2], [30, 40]]), StrokeKind.FEATURE, "nose"),), (64, 64))
        writer.add(sketch, b"a picture", truth | {"rotation": np.eye(3)})
    splits = {"train": [0], "validation": [1], "test": [2]}
    writer.finish({"side": 64, "splits": splits, "topology_id": head_template.topology_id})
    for path in (tmp_path / "set", tmp_path / "set" / "sketches.json"):
        lines, report = inspect(path)
        assert lines[0].endswith("sketches, 3 sketches of 1 people, 64 x 64 pixels") and report["sketches"] == 3
        assert lines[1:4] == [
            "splits: 3 train, 0 validation, 0 test", "curves: nose", "topology: that of the bundled models"
        ]  # fmt: skip
        assert lines[-1] == "whole"
    assert inspect(tmp_path / "set" / "strokes-0000.npz")[0][0].endswith("a part of sketches, 3 sketches")
    (tmp_path / "set" / "pictures" / "000001.png").write_bytes(b"another")
    assert inspect(tmp_path / "set")[0][-1] == "not whole: pictures changed since they were written"


def test_folders_of_textures(inspect, head, tmp_path):
    folder = write_acted_set(tmp_path / "set", head, 8)
    for path in (folder, folder / "textures.json"):
        lines, report = inspect(path)
        assert lines[0].endswith("textures, 8 people with 4 expressions, 8 x 8 texels") and report["people"] == 8
    assert inspect(folder / "shard-0000.npz")[0][0].endswith("a part of textures, 8 people")


def test_legends(inspect, refused, tmp_path):
    path = tmp_path / "p-regions.json"
    write_json(path, legend(Region, command="detect", inputs={"p.jpg": "0"}, faces=[{}, {}]))
    lines, report = inspect(path)
    assert lines[0].endswith("legend, 16 labels of a label map") and report["labels"]["skin"] == 1
    assert "made from: p.jpg" in lines and "faces: 2" in lines
    write_json(path, {"schema": "caricli.parsing/1", "labels": {"skin": 1}})
    assert inspect(path)[1]["faces"] is None
    write_json(path, {"schema": "caricli.parsing/1", "labels": {"skin": 999}})
    assert "labels from 0 to 255" in refused(COMMAND, path)


def test_a_report(inspect, tmp_path):
    write_json(tmp_path / "face.json", {"command": "refine", "version": "0.1", "inputs": {"a.npz": "0"}, "moved": 1})
    lines, report = inspect(tmp_path / "face.json")
    assert "caricli refine, version 0.1" in lines[0] and "made from: a.npz" in lines and "holds: moved" in lines
    assert report["inputs"] == {"a.npz": "0"} and report["keys"] == ["moved"]


def test_expressions_and_pictures(inspect, tmp_path):
    lines, report = inspect(asset_path("expressions.yaml"))
    assert "expressions, " in lines[0] and report["expressions"]["neutral"] == {}
    write_png(tmp_path / "photo.png", np.zeros((4, 6, 3), np.uint8))
    assert inspect(tmp_path / "photo.png")[0][0].endswith("picture, 6 x 4 pixels")


def test_bad_files_are_one_line(refused, rig, ball, tmp_path):
    write_gltf(tmp_path / "rig.glb", rig)
    (tmp_path / "cut.glb").write_bytes((tmp_path / "rig.glb").read_bytes()[:5000])
    vertices, faces = ball
    write_mesh(tmp_path / "ball.obj", Mesh(vertices, faces))
    (tmp_path / "nan.obj").write_text((tmp_path / "ball.obj").read_text().replace("v ", "v nan ", 1))
    write_face(tmp_path / "face.npz", Face(Mesh(vertices, faces)))
    (tmp_path / "cut.npz").write_bytes((tmp_path / "face.npz").read_bytes()[:900])
    (tmp_path / "cut.safetensors").write_bytes(asset_path("pca.safetensors").read_bytes()[:9000])
    (tmp_path / "photo.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    for name in ("cut.glb", "nan.obj", "cut.npz", "cut.safetensors", "photo.png", "none", "."):
        said = refused(COMMAND, tmp_path / name)
        assert (tmp_path / name).name in said, said


def test_wrong_usage(run):
    assert run(COMMAND).exit_code == 2
