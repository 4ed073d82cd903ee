"""The skin painted as expressions show it, in films, faces and pictures, and what cannot be painted."""

from dataclasses import replace

import numpy as np
import pytest

from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.face import read_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image
from caricli.io.meshes.obj import write_obj
from caricli.io.rig import write_rig
from caricli.io.strict_json import read_json, write_json
from caricli.structures import Camera, Depiction, Mesh, Pictures, Rig
from tests.painted_moods import write_brightener

pytestmark = pytest.mark.usefixtures("quick_pictures")

CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))
LONG = Pictures(np.full((32, 64, 3), 90, np.uint8))
NAMES = ("jawOpen", "mouthSmileLeft", "mouthSmileRight")


def depicted(rig, head, **actions):
    return replace(rig, depiction=Depiction(CAMERA, head.evaluate(actions=actions).astype(np.float32)))


@pytest.fixture(scope="module")
def rig(head, head_template):
    """A grey skin with three expressions, whose picture shows it at rest."""
    deltas = np.array([head.evaluate(actions={name: 1}) - head.evaluate() for name in NAMES], np.float32)
    mesh = head_template.with_vertices(head.evaluate().astype(np.float32))
    skin = Pictures(np.full((128, 128, 3), 90, np.uint8))
    return depicted(Rig(NAMES, mesh, deltas, pictures=skin, normal_deltas=deltas), head)


@pytest.fixture(scope="module")
def stage(rig, head, head_template, tmp_path_factory):
    """A folder with that rig, a network, weights of two frames, and two driving meshes."""
    folder = tmp_path_factory.mktemp("stage")
    write_rig(folder / "b.npz", rig)
    write_gltf(folder / "b.glb", rig)
    write_brightener(folder / "n.safetensors", head_template.topology_id)
    weights = {"schema": "caricli.weights/1", "fps": 10, "names": ["jawOpen"], "weights": [[0.0], [1.0]]}
    write_json(folder / "w.json", weights)
    for name, actions in {"calm": {}, "open": {"jawOpen": 0.8}}.items():
        write_obj(
            folder / f"{name}.obj", Mesh(head.evaluate(actions=actions), head.polygons, head.uvs, head.uv_polygons)
        )
    return folder


def painting(stage):
    return "--dynamic-texture", "--texture-network", stage / "n.safetensors"


def test_frames_and_films_are_painted(run, stage, tmp_path):
    line = ("animate", stage / "b.npz", stage / "w.json", "--size", 64)
    plain = run(*line, "--frames", tmp_path / "plain", "--format", "png")
    result = run(
        *line, *painting(stage), "--frames", tmp_path / "new", "--format", "png", "--video", tmp_path / "a.gif"
    )
    assert plain.exit_code == result.exit_code == 0, result.output
    assert result.stderr == "" and (tmp_path / "a.gif").stat().st_size > 1000
    for frame in ("frame-0000.png", "frame-0001.png"):
        old, new = (read_image(tmp_path / name / frame).astype(int) for name in ("plain", "new"))
        assert (new > old + 10).mean() > 0.05 and (new < old - 10).mean() < 0.005
    assert read_json(tmp_path / "new" / "animation.json")["dynamic_texture"] is True


def test_a_driven_face_wears_its_own_skin(run, stage, tmp_path):
    line = ("retarget", stage / "b.npz", stage / "open.obj", "--neutral", stage / "calm.obj", *painting(stage))
    result = run(*line, "--out", tmp_path / "open.obj")
    assert result.exit_code == 0, result.output
    face = read_face(tmp_path / "open.npz")
    skin = face.pictures.skin if face.pictures else read_image(next(tmp_path.glob("*skin*.png")))
    assert skin.shape == (128, 128, 3) and skin.max() > 110
    assert str(stage / "n.safetensors") in read_json(tmp_path / "open.json")["inputs"]


# What is changed of the rig, and what is said: an error, or a note beside the result.
FAULTS = {
    "no picture": (lambda rig, head: replace(rig, pictures=Pictures()), "needs a face with a picture on its skin"),
    "a long picture": (lambda rig, head: replace(rig, pictures=LONG), "a square picture on the skin, found 64 x 32"),
    "other names": (lambda rig, head: replace(rig, names=("a", "b", "c")), "made of ARKit's actions"),
    "another mesh": (lambda rig, head: subdivided(rig), "the head's own skin, 4200 vertices"),
}
DOUBTS = {
    "no camera": (lambda rig, head: replace(rig, depiction=None), "does not say what its picture shows"),
    "open mouth": (lambda rig, head: depicted(rig, head, jawOpen=0.8), "how lips look that close"),
    "shut eyes": (lambda rig, head: depicted(rig, head, eyeBlinkLeft=1, eyeBlinkRight=1), "shows an eye shut"),
    "an unknown one": (lambda rig, head: replace(rig, names=("jawOpen", "grin", "wink")), "shape alone"),
}


def subdivided(rig):
    """The rig of every other triangle."""
    mesh = rig.mesh
    return replace(rig, mesh=Mesh(mesh.vertices, mesh.polygons[::2], mesh.uvs, mesh.uv_polygons[::2]))


def typed(command, stage, rig):
    if command == "animate":
        return ("animate", rig, stage / "w.json", "--size", 32, "--format", "png", *painting(stage), "--frames")
    return ("retarget", rig, stage / "open.obj", *painting(stage), "--no-picture", "--out-dir")


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("command", ["animate", "retarget"])
def test_what_cannot_be_painted_is_refused(refused, stage, rig, head, tmp_path, command, fault):
    change, words = FAULTS[fault]
    write_rig(tmp_path / "bad.npz", change(rig, head))
    said = refused(*typed(command, stage, tmp_path / "bad.npz"), tmp_path / "out")
    assert "bad.npz: " in said and words in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("doubt", DOUBTS)
@pytest.mark.parametrize("command", ["animate", "retarget"])
def test_what_is_not_known_is_said(run, stage, rig, head, tmp_path, command, doubt):
    change, words = DOUBTS[doubt]
    write_rig(tmp_path / "odd.npz", change(rig, head))
    result = run(*typed(command, stage, tmp_path / "odd.npz"), tmp_path / "out")
    assert result.exit_code == 0, result.output
    notes = [line for line in result.stderr.splitlines() if "odd.npz: " in line]
    assert len(notes) == 1 and words in notes[0]


def test_a_glb_does_not_say_what_its_picture_shows(run, stage, tmp_path):
    result = run(*typed("animate", stage, stage / "b.glb"), tmp_path / "out")
    assert result.exit_code == 0 and "b.glb: it does not say what its picture shows" in result.stderr


def other_topology(tensors, about):
    return tensors, about | {"topology_id": "0" * 64}


def other_expressions(tensors, about):
    return tensors, about | {"expressions": ["smile"]}


@pytest.mark.parametrize("command", ["animate", "retarget"])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (other_topology, "network of the face's mesh"),
        (other_expressions, "of ARKit's 52 expressions, found one of others"),
    ],
)
def test_networks_of_something_else(refused, stage, tmp_path, command, change, words):
    write_checkpoint(tmp_path / "n.safetensors", *change(*read_checkpoint(stage / "n.safetensors")))
    line = [tmp_path / "n.safetensors" if word == stage / "n.safetensors" else word
            for word in typed(command, stage, stage / "b.npz")]  # fmt: skip
    assert words in refused(*line, tmp_path / "out")


def test_wrong_usage(refused, stage, tmp_path):
    line = ("animate", stage / "b.npz", stage / "w.json")
    refused(*line, *painting(stage), "--out", tmp_path / "a.glb", code=2)
    refused(*line, *painting(stage), "--frames", tmp_path / "f", code=2)
    refused(*line, *painting(stage)[1:], "--video", tmp_path / "a.gif", code=2)
    assert "none.safetensors" in refused(
        *line, "--dynamic-texture", "--texture-network", tmp_path / "none.safetensors", "--video", tmp_path / "a.gif"
    )
    assert not list(tmp_path.iterdir())
