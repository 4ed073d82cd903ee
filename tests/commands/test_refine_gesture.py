import json

import numpy as np
import pytest

from caricli.io.face import read_face, write_face
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj
from caricli.io.session import write_session
from caricli.methods.faces.encode_face import decode_face
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import Camera, Face, Mesh, Operation, Session
from tests.seen_views import view_parameters

CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))


@pytest.fixture(scope="module")
def files(head, head_template, tmp_path_factory):
    folder = tmp_path_factory.mktemp("refine")
    vertices = head.evaluate(gender=0.3, age=0.6)
    write_face(folder / "face.npz", Face(Mesh(vertices, head_template.polygons)))
    tip = CAMERA.project(vertices[head_template.annotation.landmarks[30]])
    turns = np.linspace(0, 2 * np.pi, 40)
    ring = tip + 30 * np.stack([np.cos(turns), np.sin(turns)], 1)
    region = Operation("gesture", {"points": ring.tolist(), "camera": view_parameters(CAMERA)})
    write_session(folder / "script.json", Session(None, (region, Operation("bulge", {"level": 3}))))
    return folder, vertices


def test_it_refines_a_face(run, files, head_template, tmp_path):
    folder, vertices = files
    out = tmp_path / "refined.obj"
    result = run("refine-gesture", folder / "face.npz", "--script", folder / "script.json", "--out", out)
    assert result.exit_code == 0, result.output
    assert "2 operations, moved at most" in result.stdout
    face = read_face(out.with_suffix(".npz"))
    moved = np.linalg.norm(face.vertices - vertices, axis=1)
    assert moved[head_template.annotation.landmarks[30]] > 0.005 and np.median(moved) < 1e-6
    np.testing.assert_allclose(read_obj(out).vertices, face.vertices, atol=1e-6)
    model = load_model(kind=DEFAULT_LATENT)
    assert face.model_id == model.model_id
    own = decode_face(face, model).vertices
    np.testing.assert_allclose(own - own.mean(0), face.vertices - face.vertices.mean(0), atol=1e-5)
    report = json.loads(out.with_suffix(".json").read_text())
    assert [each["name"] for each in report["operations"]] == ["region", "bulge"] and report["subdivide"] == 0
    assert read_image(out.with_suffix(".png")).std() > 0


def test_an_expression_is_in_what_is_written(run, files, tmp_path):
    folder, vertices = files
    write_session(tmp_path / "jaw.json", Session(None, (Operation("expression", {"weights": {"jawOpen": 1.0}}),)))
    out = tmp_path / "open.obj"
    words = ("--script", tmp_path / "jaw.json", "--no-picture", "--out", out)
    assert run("refine-gesture", folder / "face.npz", *words).exit_code == 0
    moved = np.linalg.norm(read_obj(out).vertices - vertices, axis=1).max()
    assert moved > 0.02
    assert json.loads(out.with_suffix(".json").read_text())["moved"] == pytest.approx(moved, abs=1e-5)


def test_the_same_script_gives_the_same_bytes(run, files, tmp_path):
    folder, _ = files
    for name in ("one", "two"):
        words = ("--script", folder / "script.json", "--no-picture", "--out", tmp_path / f"{name}.obj")
        assert run("refine-gesture", folder / "face.npz", *words).exit_code == 0
    assert (tmp_path / "one.obj").read_bytes() == (tmp_path / "two.obj").read_bytes()


def test_an_operation_that_is_refused_is_named(refused, files, tmp_path):
    folder, _ = files
    write_session(tmp_path / "bad.json", Session(None, (Operation("deselect"), Operation("bulge", {"level": 1}))))
    words = ("--script", tmp_path / "bad.json", "--out", tmp_path / "out.obj")
    assert "bad.json: operation 1: bulge: expected a region or handles" in refused(
        "refine-gesture", folder / "face.npz", *words
    )
    assert not (tmp_path / "out.obj").exists()
