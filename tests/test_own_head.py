"""A head of many parts, in centimetres, with its own expressions: every command of docs/own_head.md."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from caricli.cli import cli
from caricli.data.dataset import read_dataset
from caricli.geometry.repair.components import mesh_components
from caricli.io.face import read_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.meshes.mesh import read_mesh
from caricli.io.rig import read_rig
from caricli.io.strict_json import read_json
from caricli.methods.rig.add_parts import choose_parts
from caricli.structures import HeadChoice

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "own_head.md").read_text("utf-8")
pytestmark = pytest.mark.slow

SIZES = ("--people 100 --acting 20", "--people 24 --acting 8 --levels 0")
FEW = {
    "train intrinsic": "--set dimension=12",
    "train pca": "--set dimension=12",
    "texture": "--size 256",
}
"""What makes the commands of the page quick."""


def commands():
    """The commands of the page as one script, on a coarse head with few people."""
    script = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.S))
    assert SIZES[0] in script
    script = script.replace(*SIZES)
    for command, option in FEW.items():
        assert f"caricli {command} " in script
        script = script.replace(f"caricli {command} ", f"caricli {command} {option} ")
    return script


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The folder that the page fills, and what its commands print."""
    folder = tmp_path_factory.mktemp("page")
    shim = folder / "bin"
    shim.mkdir()
    for name, call in (("caricli", f'"{sys.executable}" -m caricli'), ("python", f'"{sys.executable}"')):
        (shim / name).write_text(f'#!/bin/sh\nexec {call} "$@"\n')
        (shim / name).chmod(0o755)
    (folder / "examples").symlink_to(ROOT / "examples")
    environment = os.environ | {"PATH": f"{shim}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    script = ["bash", "-euo", "pipefail", "-c", commands()]
    done = subprocess.run(script, env=environment, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "own", done.stdout


def test_the_dataset_is_in_metres_and_knows_who_shows_what(own):
    folder, printed = own
    assert "taken as given in cm" in printed and "own/head: 24 people in meshes, 53 expressions, " in printed
    data = read_dataset(folder / "dataset")
    assert mesh_components(data.template.vertices, data.template.faces).count >= 8
    assert 0.2 < data.template.height < 0.35
    assert len(np.unique(data.identity)) == 24 and len(data.manifest["expressions"]) > 20
    assert (data.level == 2).sum() == 8


@pytest.mark.parametrize("kind", ["pca", "intrinsic"])
def test_models_hold_all_of_its_parts(own, kind):
    error = read_json(own[0] / f"{kind}.json")["shape_error"]
    # A component that has come loose alone costs several percent.
    assert error["train"]["percent"] < 1.2


def test_the_face_meets_its_landmarks_and_keeps_its_parts(own):
    folder, _ = own
    assert read_json(folder / "face.json")["nme"] < 1
    assert read_json(folder / "refined.json")["after"]["all"] < 0.1
    face = read_face(folder / "refined.npz")
    data = read_dataset(folder / "dataset")
    components = mesh_components(data.template.vertices, data.template.faces)
    # As far from where the skin takes them as those of people are, or little farther.
    apart = np.linalg.norm(components.hangers @ face.vertices, axis=1)
    usual = np.max([np.linalg.norm(components.hangers @ shape, axis=1) for shape in data.vertices], axis=0)
    assert (apart < 2 * usual + 0.003).all()


def test_its_face_has_a_chart_of_its_own(own):
    folder = own[0] / "textured"
    face = read_face(folder / "face-arap.npz")
    corners = face.mesh.uvs[face.mesh.uv_faces]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    assert len(face.vertices) < len(read_face(folder / "face.npz").vertices) / 2
    assert face.pictures.skin.std() > 10


def test_its_lines_are_followed(own, tmp_path):
    folder, _ = own
    model = ("--model", str(folder / "intrinsic.safetensors"))
    drawn = ("sketch", str(folder / "face.npz"), *model, "--out", str(tmp_path / "lines.json"))
    followed = ("reconstruct-from-sketch", str(tmp_path / "lines.json"), *model, "--out", str(tmp_path / "face.obj"))
    for words in (drawn, followed):
        result = CliRunner().invoke(cli, words)
        assert result.exit_code == 0, result.output
    # An outline that is open at the chin is missed by several times as much, and so is all else.
    assert read_json(tmp_path / "face.json")["line_errors"]["all"] < 0.3


def test_a_pulled_point_arrives(own):
    figures = read_json(own[0] / "nose.json")
    assert figures["handles"][0]["reached"] > 0.95 and figures["energy_elsewhere"] < 0.6


def test_the_rig_has_its_own_expressions_under_arkits_names_and_its_picture(own):
    folder, _ = own
    rig = read_rig(folder / "rig.npz")
    assert len(rig.names) == 55 and {"eyeBlinkLeft", "browInnerUp", "browInnerUp_L", "jawOpen"} <= set(rig.names)
    assert read_gltf(folder / "rig.glb").pictures.skin.std() > 10
    whole = rig
    rig = choose_parts(whole, HeadChoice(("skin",)))
    neutral = read_mesh(folder / "head" / "expressions" / "neutral.obj")
    assert len(rig.neutral) == len(neutral.vertices) < len(whole.neutral)
    parts = mesh_components(rig.neutral, rig.faces)
    moved = [
        np.linalg.norm(parts.averages @ rig.deltas[rig.names.index(name)], axis=1) for name in ("jawOpen", "cheekPuff")
    ]
    # The jaw takes teeth and tongue along, and no expression takes a part away from the face.
    assert (moved[0] > 0.003).sum() >= 2 and moved[1][1:].max() < 0.003
    assert np.linalg.norm(rig.deltas, axis=2).max() < 0.08


def test_blendshapes_of_its_own(own):
    rig = read_rig(own[0] / "blendshapes.npz")
    assert len(rig.names) == 55 and np.linalg.norm(rig.deltas, axis=2).max() < 0.08
