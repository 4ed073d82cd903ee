from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.face import write_face
from caricli.io.meshes.mesh import write_mesh
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.expression_templates import load_action_units, load_templates
from caricli.store.expression_tools import ToolPaths, load_caricature, load_tools
from caricli.store.models import model_path
from caricli.store.rig_sources import PictureSources
from caricli.structures import Camera, Face, Mesh
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.detection import FacePicture
from caricli.structures.landmarks import Landmarks


@pytest.fixture(scope="module")
def tools():
    return load_tools()[0]


def test_bundled_tools_make_52_expressions(tools):
    bundled, files = load_tools()
    assert len(tools.expressions) == 53 and next(iter(tools.expressions)) == "neutral"
    assert tools.templates.names == tuple(tools.expressions) and tools.acting.names == tools.templates.names[1:]
    assert bundled.latent is None and [path.name for path in files] == ["landmark_map.safetensors"]
    assert sorted(load_action_units()) == sorted(ARKIT_NAMES)


def test_ones_own_templates_take_the_names_of_the_models_mesh(head_template, head, tmp_path):
    write_mesh(tmp_path / "neutral.obj", head_template)
    smile = head.evaluate(actions={"mouthSmileLeft": 1.0})
    write_mesh(tmp_path / "Smile.obj", head_template.with_vertices(smile))
    templates, files = load_templates(tmp_path)
    assert templates.names == ("Smile",) and templates.annotation is None and len(files) == 2
    own, _ = load_tools(ToolPaths(templates=tmp_path))
    assert list(own.expressions) == ["neutral", "Smile"] and own.templates.annotation is not None


def test_a_model_knows_the_mesh_of_ones_own_templates(head_template, head, tmp_path):
    for name, actions in (("neutral", {}), ("Smile", {"mouthSmileLeft": 1.0})):
        write_mesh(tmp_path / f"{name}.obj", head_template.with_vertices(100 * head.evaluate(actions=actions)))
    model = model_path("pca")
    templates, files = load_templates(tmp_path, model)
    assert templates.annotation is not None and files[-1] == model
    np.testing.assert_allclose(templates.neutral, head_template.vertices, atol=1e-6)
    (tmp_path / "other").mkdir()
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    for name, stretch in (("neutral", 1.0), ("tall", 1.05)):
        tetrahedron = Mesh(stretch * corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
        write_mesh(tmp_path / "other" / f"{name}.obj", tetrahedron)
    with pytest.raises(InputError, match="pca.safetensors: expected the topology of the templates"):
        load_templates(tmp_path / "other", model)


def test_expressions_in_another_unit_or_place_than_the_neutral_face_are_refused(head_template, head, tmp_path):
    write_mesh(tmp_path / "neutral.obj", head_template)
    smile = head.evaluate(actions={"mouthSmileLeft": 1.0})
    for vertices in (10 * smile, smile + [0, 0.05, 0]):
        write_mesh(tmp_path / "Smile.obj", head_template.with_vertices(vertices))
        with pytest.raises(InputError, match="Smile.obj: expected a face in the unit and the place of neutral.obj"):
            load_templates(tmp_path)


def test_one_half_alone_is_not_the_whole(head_template, head, tmp_path):
    write_mesh(tmp_path / "neutral.obj", head_template)
    brow = head.evaluate(actions={"browInnerUp": 0.5})
    write_mesh(tmp_path / "browInnerUp_L.obj", head_template.with_vertices(brow))
    assert load_templates(tmp_path)[0].names == ("browInnerUp_L",)


def test_templates_of_other_units_and_names_become_arkits_in_metres(head_template, head, tmp_path):
    write_mesh(tmp_path / "neutral.obj", head_template.with_vertices(100 * head_template.vertices))
    actions = {"eyeBlink_L": "eyeBlinkLeft", "Pout": "mouthPucker"}
    for name, action in actions.items():
        shape = head.evaluate(actions={action: 1.0})
        write_mesh(tmp_path / f"{name}.obj", head_template.with_vertices(100 * shape))
    brow = head.evaluate(actions={"browInnerUp": 1.0}) - head_template.vertices
    for name, side in (("browInnerUp_L", 0.3), ("browInnerUp_R", 0.7)):
        shape = head_template.vertices + side * brow
        write_mesh(tmp_path / f"{name}.obj", head_template.with_vertices(100 * shape))
    templates, _ = load_templates(tmp_path)
    assert templates.names == ("Pout", "browInnerUp_L", "browInnerUp_R", "eyeBlinkLeft", "browInnerUp")
    own = load_tools(ToolPaths(templates=tmp_path))[0].templates
    np.testing.assert_allclose(own.neutral, head_template.vertices, atol=1e-7)
    np.testing.assert_allclose(own.deltas[own.names.index("browInnerUp")], brow, atol=1e-7)
    write_mesh(tmp_path / "EyeBlinkLeft.obj", head_template.with_vertices(100 * head_template.vertices))
    with pytest.raises(InputError, match="found 'eyeBlinkLeft' twice under two names"):
        load_templates(tmp_path)


def test_expressions_that_move_nothing_are_refused(head_template, head, tmp_path):
    (tmp_path / "set.yaml").write_text("neutral: {}\na: {cheekPuff: 1}\n")
    folder = tmp_path / "templates"
    folder.mkdir()
    for name, actions in {"neutral": {}, "jawOpen": {"jawOpen": 1.0}, "cheekPuff": {}}.items():
        write_mesh(folder / f"{name}.obj", head_template.with_vertices(head.evaluate(actions=actions)))
    with pytest.raises(InputError, match="set.yaml: expected expressions that move something"):
        load_tools(ToolPaths(expressions=tmp_path / "set.yaml", templates=folder))


def test_a_caricature_has_a_camera(tools, head_template, tmp_path):
    camera = Camera(1500.0, np.diag([1.0, -1, -1]), np.zeros(2))
    write_face(tmp_path / "seen.npz", Face(head_template, camera))
    caricature = load_caricature(tmp_path / "seen.npz", tools)
    face, pictures = caricature.face, caricature.worn
    assert face.camera is not None and pictures == PictureSources() and pictures.files == []
    write_face(tmp_path / "blind.npz", Face(head_template))
    with pytest.raises(InputError, match="blind.npz: expected a face with the camera"):
        load_caricature(tmp_path / "blind.npz", tools)
    write_mesh(tmp_path / "face.obj", head_template)
    with pytest.raises(InputError, match="found a mesh, which has no camera"):
        load_caricature(tmp_path / "face.obj", tools)


def test_a_face_is_fitted_to_landmarks_as_sure_as_they_are(head_template, tools, monkeypatch, tmp_path):
    points = 900 * head_template.vertices[head_template.annotation.landmarks][:, :2] * [1, -1] + 200
    spreads = np.arange(1, 82)[:, None, None] * np.eye(2)
    picture = FacePicture(Landmarks(points, None, spreads))
    asked = []

    def fit(marks, model, spreads):
        asked.append((marks, spreads))
        return fit_landmarks(marks, model, spreads=spreads)

    monkeypatch.setattr("caricli.store.expression_tools.fit_landmarks", fit)
    reader: Any = SimpleNamespace(read=lambda source, count: picture)
    load_caricature(tmp_path / "a.json", tools, reader=reader)
    assert np.array_equal(asked[0][0], points) and np.array_equal(asked[0][1], spreads)
