"""What a face wears stays on it through every command that reads a face and writes one."""

import importlib

import numpy as np
import pytest

from caricli.cli import COMMANDS
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.meshes.mtl import material_pictures
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.rig import read_rig
from caricli.io.session import write_session
from caricli.io.strict_json import write_json
from caricli.store.models import load_model
from caricli.store.session_tools import start_of
from caricli.structures import Camera, Face, Hair, Material, Mesh, Operation, Pictures, Session
from tests.seen_views import view_parameters

CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))
SKIN = np.array([40, 160, 60], np.uint8)
EYES = np.array([30, 60, 200], np.uint8)
HAIR = np.array([200, 30, 160], np.uint8)

# What is typed, with {} for the folder of the inputs, and what is written beside the mesh that it names.
WEARERS = {
    "edit-handle": "edit-handle {face} --handle nose_tip=0,0,2% --out {out}/new.obj",
    "refine-gesture": "refine-gesture {face} --script {strokes} --out {out}/new.obj",
    "edit-semantic": "edit-semantic {face} --label BigNose=1 --out {out}/new.obj",
    "caricaturize": "caricaturize {face} --mode own --out {out}/new.obj",
    "interpolate": "interpolate {face} {face} --steps 2 --out-dir {out}",
    "refine": "refine {face} {marks} --out {out}/new.obj",
    "fit-morphable": "fit-morphable {marks} --expression-only --identity {face} --out {out}/new.obj",
    "studio": "studio {face} --replay {session} --out {out}/new.obj",
    "encode": "encode {face} --out {out}/new.npz",
    "rig": "rig {face} --parts skin,hair --out {out}/new.glb",
    "blendshapes": "blendshapes {face} --expressions {moods} --method transfer --out {out}/new.npz",
    "retarget": "retarget {rig} {driver} --neutral {driver} --out {out}/new.obj",
    "animate": "animate {rig} {weights} --frames {out}/new --out {out}/new.glb",
}
# Commands that write no face of a face that they read, and why.
BARE = {
    "portrait": "reads pictures",
    "reconstruct-from-landmarks": "reads landmarks",
    "reconstruct-from-sketch": "reads sketches",
    "fit-coarse": "reads pictures",
    "texture": "paints the face anew",
    "sample": "reads no face",
    "detect": "reads pictures",
    "stylise": "reads and writes pictures",
    "map-landmarks": "reads and writes landmarks",
    "dataset build": "reads no face",
    "dataset import": "a dataset holds shapes",
    "dataset show": "writes a picture",
    "dataset pictures": "draws people of a dataset",
    "dataset sketches": "draws people of a dataset",
    "dataset textures": "draws people of a dataset",
    "template export": "reads no face",
    "render": "writes a picture",
    "sketch": "writes lines",
    "inspect": "writes nothing",
} | {name: "reads and writes no face" for name in COMMANDS if name.startswith(("train ", "evaluate "))}


def test_every_command_is_here():
    typed = {name for name, (module, _, _) in COMMANDS.items() if module}
    assert typed == {*WEARERS, *BARE}, "say how a new command keeps what a face wears, or why it need not"


def cap(mesh):
    """Hair of the topmost triangles, a centimetre above the skin."""
    roots = mesh.faces[mesh.vertices[mesh.faces][..., 1].mean(1).argsort()[-200:]]
    used, faces = np.unique(roots, return_inverse=True)
    faces = faces.reshape(roots.shape).astype(np.int32)
    shell = Mesh(mesh.vertices[used] + [0, 0.01, 0], faces, np.full((1, 2), 0.5), 0 * faces)
    return Hair(shell, np.repeat(used[:, None], 3, 1).astype(np.int32), np.full((len(used), 3), 1 / 3))


def nose_bulge(marks):
    """A session: a region around the nose bulges."""
    turns = np.linspace(0, 2 * np.pi, 30)
    ring = marks[30] + 30 * np.stack([np.cos(turns), np.sin(turns)], 1)
    region = Operation("region", {"points": ring.tolist(), "camera": view_parameters(CAMERA)})
    return Session(None, (region, Operation("bulge", {"level": 2})))


@pytest.fixture(scope="module")
def painted(head, head_template, small_pictures, tmp_path_factory):
    """A folder of a green face with blue eyes and purple hair, whose UVs are not the template's, and of what commands
    need besides."""
    folder = tmp_path_factory.mktemp("painted")
    vertices = head.evaluate(gender=0.3, age=0.6)
    mesh = Mesh(vertices, head_template.polygons, 0.5 * head_template.uvs, head_template.uv_polygons)
    colours = {"skin": SKIN, "eyes": EYES, "hair": HAIR}
    pictures = Pictures(**{name: np.full((32, 32, 3), colour) for name, colour in colours.items()})
    marks = CAMERA.project(vertices[head_template.annotation.landmarks[:68]])
    write_face(folder / "face.npz", Face(mesh, CAMERA, marks, pictures=pictures, hair=cap(mesh)))
    np.savetxt(folder / "marks.txt", marks)
    write_obj(folder / "driver.obj", load_model("morphable").template)
    (folder / "moods.yaml").write_text("neutral: {}\nopen: {jawOpen: 0.8}\n")
    weights = {"schema": "caricli.weights/1", "fps": 10, "names": ["open"], "weights": [[0.0], [1.0]]}
    write_json(folder / "weights.json", weights)
    write_session(folder / "strokes.json", nose_bulge(marks))
    steps = (
        Operation("semantic", {"strengths": {"BigNose": 1}}),
        Operation("expression", {"weights": {"jawOpen": 0.5}}),
    )
    write_session(folder / "session.json", Session(start_of(folder / "face.npz"), steps))
    return folder


@pytest.fixture(scope="module")
def rig(run, painted):
    """The rig of the face, for commands that start from one."""
    line = (
        f"blendshapes {painted}/face.npz --expressions {painted}/moods.yaml --method transfer --out {painted}/rig.npz"
    )
    result = run(*line.split())
    assert result.exit_code == 0, result.output
    return painted / "rig.npz"


def typed(line, painted, rig, out):
    names = {
        "face": "face.npz",
        "marks": "marks.txt",
        "moods": "moods.yaml",
        "driver": "driver.obj",
        "session": "session.json",
    }
    paths = {key: painted / name for key, name in names.items()} | {"weights": painted / "weights.json", "rig": rig}
    paths["strokes"] = painted / "strokes.json"
    return line.format(out=out, **paths).split()


@pytest.mark.parametrize("name", WEARERS)
def test_it_keeps_what_the_face_wears(run, painted, rig, tmp_path, name):
    result = run(*typed(WEARERS[name], painted, rig, tmp_path))
    assert result.exit_code == 0, result.output
    files = sorted(path for path in tmp_path.rglob("*") if path.is_file())
    uvs = read_face(painted / "face.npz").mesh.uvs
    seen = [check(path, uvs) for path in files for check in (obj_wears, npz_wears, glb_wears, sheet_shows)]
    assert any(seen), files


LINKED = {
    "new.obj": WEARERS["edit-semantic"],
    "new.glb": WEARERS["edit-semantic"].replace(".obj", ".glb"),
    "new.npz": WEARERS["encode"],
    "face.npz": "encode {face} --out-dir {out}",
}


@pytest.mark.parametrize("name", LINKED)
def test_what_goes_beside_a_file_goes_where_its_link_leads(run, painted, rig, tmp_path, name):
    links = tmp_path / "links"
    links.mkdir()
    (links / name).symlink_to(tmp_path / "real" / f"own{name[-4:]}")
    result = run(*typed(LINKED[name], painted, rig, links), "--overwrite")
    assert result.exit_code == 0, result.output
    assert [path.name for path in links.iterdir()] == [name] and (links / name).is_symlink()
    files = sorted((tmp_path / "real").iterdir())
    assert {"own.npz", "own.json", "own-skin.png"} < {path.name for path in files}
    assert all(path.name.startswith("own") for path in files)
    uvs = read_face(painted / "face.npz").mesh.uvs
    assert any(check(path, uvs) for path in files for check in (obj_wears, npz_wears))


def draws(name):
    """Whether a command can be told not to draw."""
    module = importlib.import_module(f"caricli.commands.{COMMANDS[name][0]}")
    return any("--no-picture" in (*option.opts, *option.secondary_opts) for option in module.command.params)


def test_what_draws_a_picture_of_a_face_need_not():
    assert {name for name in WEARERS if not draws(name)} == {"interpolate", "animate"}
    assert draws("reconstruct-from-landmarks") and draws("texture")


@pytest.mark.parametrize("name", ["edit-handle", "refine", "encode", "rig", "blendshapes", "retarget"])
def test_no_picture_is_drawn_and_all_else_is_the_same(run, painted, rig, tmp_path, name, monkeypatch):
    monkeypatch.setattr("caricli.render.shade.shade", None)
    words = typed(WEARERS[name], painted, rig, tmp_path)
    result = run(*words, "--no-picture")
    assert result.exit_code == 0, result.output
    files = {path.name for path in tmp_path.iterdir()}
    assert "new.png" not in files and {"new.npz", "new.json"} < files


def obj_wears(path, uvs):
    """Every OBJ names both pictures, which lie beside it, and has the UVs of the face."""
    if path.suffix != ".obj":
        return False
    named = material_pictures(path)
    for material, colour in (("face", SKIN), ("eyes", EYES)):
        assert (read_image(named[material]) == colour).all(), path
    np.testing.assert_allclose(read_obj(path).uvs[: len(uvs)], uvs, atol=1e-6)
    return True


def npz_wears(path, uvs):
    """Every face names both, and every rig holds them."""
    if path.suffix != ".npz":
        return False
    with np.load(path) as arrays:
        is_rig = str(arrays["schema"]) == "caricli.rig/1"
    face = read_rig(path).face if is_rig else read_face(path)
    assert (face.pictures.skin == SKIN).all() and (face.pictures.hair == HAIR).all(), path
    assert hair_stands(face), path
    assert face.pictures.eyes is None or (face.pictures.eyes == EYES).all(), path
    np.testing.assert_allclose(face.mesh.uvs[: len(uvs)], uvs, atol=1e-6)
    return True


def hair_stands(face):
    """Whether the hair is a centimetre above the skin, on its own or as a part of the mesh."""
    if face.hair is not None:
        above = face.hair.shell.vertices - face.vertices[face.hair.roots[:, 0]]
        return np.allclose(above, [0, 0.01, 0], atol=1e-6)
    hair = np.unique(face.faces[face.triangle_materials == Material.HAIR])
    above = face.vertices[hair, 1].max() - face.vertices[:4200, 1].max()
    return len(hair) > 50 and abs(above - 0.01) < 1e-6


def glb_wears(path, uvs):
    """Every GLB embeds skin and hair."""
    if path.suffix != ".glb":
        return False
    rig = read_gltf(path)
    assert np.abs(rig.pictures.skin.astype(int) - SKIN).max() <= 8, path
    assert np.abs(rig.pictures.hair.astype(int) - HAIR).max() <= 8 and hair_stands(rig.face), path
    return True


def sheet_shows(path, uvs):
    """Every picture of faces shows the green skin and the purple hair."""
    if path.suffix != ".png" or path.stem.endswith(("-skin", "-eyes", "-hair")):
        return False
    red, green, blue = read_image(path).astype(int).transpose(2, 0, 1)
    assert ((green > red + 30) & (green > blue + 30)).mean() > 0.02, path
    assert ((red > green + 30) & (blue > green + 30)).mean() > 0.002, path
    return True
