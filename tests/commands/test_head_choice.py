"""What a head consists of is chosen by the same options in every command that makes one."""

import importlib

import numpy as np
import pytest

from caricli.cli import COMMANDS
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.meshes.mesh import read_mesh
from caricli.io.meshes.obj import write_obj
from caricli.io.rig import read_rig
from caricli.io.session import write_session
from caricli.io.sketches.sketch import write_sketch
from caricli.io.strict_json import write_json
from caricli.methods.sketch.draw_sketch import draw_sketch
from caricli.store.models import load_model
from caricli.structures import Camera, Face, Material, Mesh, Operation, Session
from caricli.template.feature_curves import feature_curves

CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))
SHIRT = {Material.BUST, Material.CLOTH}
TEETH = {Material.TEETH, Material.GUMS}
CHOICE = ("--parts", "skin,eyes,teeth", "--bust", "--teeth", "cartoon")
CROWNS = {"natural": 28, "cartoon": 20}
CROWN = 28  # polygons

MAKERS = {
    "edit-handle": "edit-handle {face} --handle nose_tip=0,0,2% --no-picture --out {out}/new.glb",
    "edit-semantic": "edit-semantic {face} --label BigNose=1 --no-picture --out {out}/new.glb",
    "caricaturize": "caricaturize {face} --mode own --no-picture --out {out}/new.glb",
    "refine-gesture": "refine-gesture {face} --script {strokes} --no-picture --out {out}/new.glb",
    "refine": "refine {face} {marks} --no-picture --out {out}/new.glb",
    "fit-morphable": "fit-morphable {marks} --no-picture --out {out}/new.glb",
    "reconstruct-from-landmarks": "reconstruct-from-landmarks {marks} --no-picture --out {out}/new.glb",
    "reconstruct-from-sketch": "reconstruct-from-sketch {sketch} --no-picture --out {out}/new.glb",
    "sample": "sample --count 1 --out-dir {out}",
    "interpolate": "interpolate {face} {face} --steps 2 --out-dir {out}",
}
"""Commands whose mesh is the skin unless something is chosen."""

DRESSERS = {
    "rig": "rig {face} --neutral as-is --no-picture --out {out}/new.glb",
    "blendshapes": "blendshapes {face} --expressions {moods} --method transfer --no-picture --out {out}/new.npz",
}
"""Commands whose head is whole unless something is chosen."""

OTHERS = ("texture", "portrait", "fit-coarse", "render", "animate", "retarget")


def test_every_command_that_makes_a_head_is_here():
    """`texture` and `portrait` have tests of their own, `fit-coarse` fits as `fit-morphable`; others take heads."""
    modules = {name: module for name, (module, _, _) in COMMANDS.items() if module}
    commands = {name: importlib.import_module(f"caricli.commands.{path}").command for name, path in modules.items()}
    options = {name: {word for one in command.params for word in one.opts} for name, command in commands.items()}
    choosing = {name for name, words in options.items() if "--parts" in words}
    assert choosing == {*MAKERS, *DRESSERS, *OTHERS}
    assert {name for name in choosing if "--teeth" not in options[name]} == {"animate", "retarget"}
    assert all("--bust" in options[name] for name in choosing)


@pytest.fixture(scope="module")
def files(head, head_template, small_pictures, tmp_path_factory):
    """Paths by name of a plain face and of what commands need besides."""
    folder = tmp_path_factory.mktemp("plain")
    vertices = head.evaluate(gender=0.3, age=0.6)
    points = CAMERA.project(vertices[head_template.annotation.landmarks[:68]])
    write_face(folder / "face.npz", Face(Mesh(vertices, head_template.polygons), CAMERA, points))
    np.savetxt(folder / "marks.txt", points)
    write_sketch(
        folder / "sketch.json", draw_sketch(vertices, feature_curves(head_template.annotation), CAMERA, (400, 440))
    )
    (folder / "moods.yaml").write_text("neutral: {}\nopen: {jawOpen: 0.8}\n")
    write_session(folder / "strokes.json", Session(None, (Operation("deselect"),)))
    write_obj(folder / "driver.obj", load_model("morphable").template)
    weights = {"schema": "caricli.weights/1", "fps": 10, "names": ["open"], "weights": [[0.0], [1.0]]}
    write_json(folder / "weights.json", weights)
    return {path.stem: path for path in folder.iterdir()}


@pytest.fixture(scope="module")
def rig(run, files, tmp_path_factory):
    """A rig with all parts and one expression, as GLB and NPZ."""
    folder = tmp_path_factory.mktemp("rig")
    result = run(*DRESSERS["blendshapes"].format(out=folder, **files).split())
    assert result.exit_code == 0, result.output
    return folder / "new.npz"


def crowns(rig):
    """How many teeth there are, whose polygons are split in a GLB."""
    return (rig.triangle_materials == Material.TEETH).sum() / CROWN / 2


@pytest.mark.parametrize("name", MAKERS)
def test_the_mesh_is_the_head_that_is_chosen_and_the_npz_the_skin(run, files, tmp_path, name):
    result = run(*MAKERS[name].format(out=tmp_path, **files).split(), *CHOICE)
    assert result.exit_code == 0, result.output
    (npz, *_) = sorted(tmp_path.glob("*.npz"))
    face = read_face(npz)
    assert len(face.vertices) == 4200 and face.materials is None and not face.pictures
    if name in ("sample", "interpolate"):
        words = npz.with_suffix(".obj").read_text().split()
        assert {words[k + 1] for k, word in enumerate(words) if word == "usemtl"} == {
            "face",
            "eyes",
            "teeth",
            "gums",
            "bust",
            "cloth",
        }
        assert npz.with_name(f"{npz.stem}-eyes.png").is_file()
        np.testing.assert_allclose(read_mesh(npz.with_suffix(".obj")).vertices[:4200], face.vertices, atol=1e-6)
        return
    glb = read_gltf(npz.with_suffix(".glb"))
    assert {*glb.materials} == {Material.SKIN, Material.EYE} | TEETH | SHIRT
    assert crowns(glb) == CROWNS["cartoon"] and glb.pictures.eyes is not None
    np.testing.assert_allclose(glb.neutral[:4200], face.vertices, atol=1e-6)


@pytest.mark.parametrize("name", ["edit-handle", "reconstruct-from-landmarks"])
def test_where_nothing_is_chosen_the_mesh_goes_on_to_other_commands(run, files, tmp_path, name):
    result = run(*MAKERS[name].format(out=tmp_path, **files).split())
    assert result.exit_code == 0, result.output
    assert len(read_mesh(tmp_path / "new.glb").vertices) == 4200
    assert {path.suffix for path in tmp_path.iterdir()} == {".glb", ".npz", ".json"}


def test_the_picture_is_of_what_is_chosen(run, files, tmp_path):
    words = MAKERS["edit-handle"].replace("--no-picture ", "").format(out=tmp_path, **files).split()
    pictures = []
    for more in ((), ("--parts", "skin"), ("--bust",)):
        assert run(*words, *more, "--overwrite").exit_code == 0
        pictures.append(read_image(tmp_path / "new.png").astype(int))
    plain, bare, clothed = pictures
    assert np.abs(plain - bare).max() > 60
    bluish = [((picture[..., 2] > picture[..., 0] + 10).mean()) for picture in pictures]
    assert bluish[2] > 0.02 > 10 * max(bluish[:2]), bluish
    assert clothed.shape == plain.shape


@pytest.mark.parametrize("name", DRESSERS)
def test_a_rig_is_of_what_is_chosen(run, files, tmp_path, name):
    words = DRESSERS[name].format(out=tmp_path, **files).split()
    for more, materials, teeth in (
        ((), {*Material} - {Material.HAIR, Material.CLOTH}, "natural"),
        (CHOICE, {Material.SKIN, Material.EYE} | TEETH | SHIRT, "cartoon"),
    ):
        result = run(*words, *more, "--overwrite")
        assert result.exit_code == 0, result.output
        for rig in (read_rig(tmp_path / "new.npz"), read_gltf(tmp_path / "new.glb")):
            assert {*rig.materials} == materials and crowns(rig) == CROWNS[teeth]


@pytest.mark.parametrize("suffix", [".npz", ".glb"])
def test_a_rig_that_is_there_gets_shoulders(run, files, rig, tmp_path, suffix):
    out = tmp_path / "new.glb"
    result = run("animate", rig.with_suffix(suffix), files["weights"], "--parts", "skin,teeth", "--bust", "--out", out)
    assert result.exit_code == 0, result.output
    before = read_rig(rig)
    after = read_gltf(out)
    assert {*after.materials} == {Material.SKIN} | TEETH | SHIRT and after.names == before.names
    np.testing.assert_allclose(after.deltas[:, :4200], before.deltas[:, :4200], atol=1e-6)
    # They begin where the skin ends, so that nothing is between them.
    cut = np.intersect1d(after.neutral[:4200], after.neutral[np.unique(after.faces[after.triangle_materials == 7])])
    assert len(cut) >= 40


def test_a_face_that_is_driven_is_of_what_is_chosen(run, files, rig, tmp_path):
    driver = files["driver"]
    words = ("retarget", rig, driver, "--neutral", driver, "--no-picture", "--out", tmp_path / "new.obj")
    assert run(*words, "--parts", "skin").exit_code == 0
    assert len(read_mesh(tmp_path / "new.obj").vertices) == 4200
    assert run(*words, "--bust", "--overwrite").exit_code == 0
    assert {*read_face(tmp_path / "new.npz").materials} >= TEETH | SHIRT


def test_what_is_drawn_is_of_what_is_chosen(run, files, rig, tmp_path):
    out = tmp_path / "a.png"
    for path, more in ((files["face"], ("--teeth", "cartoon")), (rig, ())):
        pictures = []
        for bust in ((), ("--bust",)):
            words = ("render", path, "--size", 48, "--views", "front", "-o", out, "--overwrite")
            result = run(*words, *bust, *more)
            assert result.exit_code == 0, result.output
            pictures.append(read_image(out).astype(int))
        cloth = [(picture[..., 2] > picture[..., 0] + 10).mean() for picture in pictures]
        assert cloth[0] < 0.01 < 0.05 < cloth[1]


def test_an_overlay_shows_all_parts(run, files, tmp_path):
    paper = np.full((420, 400, 3), 255, np.uint8)
    from caricli.io.image import write_png

    write_png(tmp_path / "paper.png", paper)
    pictures = []
    for parts in ("skin", "skin,lashes", "skin,eyes"):
        words = ("render", files["face"], "--image", tmp_path / "paper.png", "-o", tmp_path / "a.png", "--parts", parts)
        assert run(*words, "--overwrite").exit_code == 0
        pictures.append(read_image(tmp_path / "a.png").astype(int))
    assert (pictures[0] - pictures[1]).max() > 30 and np.abs(pictures[0] - pictures[2]).max() > 30


class TestWhatIsRefused:
    """One line, exit 1, nothing written."""

    def test_shoulders_for_another_topology(self, run, refused, files, rig, tmp_path, egg):
        out = tmp_path / "new"
        fine = tmp_path / "fine.glb"
        words = ("rig", files["face"], "--neutral", "as-is", "--parts", "skin", "--subdivide", 1, "--no-picture")
        assert run(*words, "--out", fine).exit_code == 0
        said = refused("animate", fine, files["weights"], "--bust", "--out", f"{out}.glb")
        assert f"{fine}: expected a skin of the bundled head's topology for shoulders (--bust)" in said
        egg.write(tmp_path / "egg.obj", np.zeros(4))
        said = refused("render", tmp_path / "egg.obj", "--bust", "-o", f"{out}.png")
        assert "egg.obj: expected a skin of the bundled head's topology" in said
        assert not [*tmp_path.glob("new*")]

    @pytest.mark.parametrize("teeth", CROWNS)
    def test_teeth_for_a_head_that_has_its_own(self, refused, rig, tmp_path, teeth):
        said = refused("render", rig, "--teeth", teeth, "-o", tmp_path / "new.png")
        assert f"{rig}: has its parts already" in said and not [*tmp_path.iterdir()]

    def test_teeth_for_another_topology(self, refused, tmp_path, egg):
        egg.write(tmp_path / "egg.obj", np.zeros(4))
        said = refused("render", tmp_path / "egg.obj", "--teeth", "cartoon", "-o", tmp_path / "new.png")
        assert "egg.obj: expected a skin of the bundled head's topology for --teeth, found another" in said
        assert not [*tmp_path.glob("new*")]

    def test_teeth_that_are_not_among_the_parts(self, run, files, tmp_path):
        result = run("rig", files["face"], "--parts", "skin,eyes", "--teeth", "cartoon", "--out", tmp_path / "new.glb")
        assert result.exit_code == 2 and "--teeth are not among --parts" in result.stderr
        assert not [*tmp_path.iterdir()]

    def test_parts_and_teeth_that_nobody_has(self, run, files, tmp_path):
        for words in (("--parts", "skin,beard"), ("--parts", "teeth"), ("--teeth", "wooden")):
            result = run("sample", "--out-dir", tmp_path / "new", *words)
            assert result.exit_code == 2 and words[0] in result.output and not (tmp_path / "new").exists()
