import re
from pathlib import Path

import pytest

import caricli
from caricli.cli import COMMANDS

FOLDER = Path(caricli.__file__).parent / "commands"


@pytest.mark.parametrize(
    "args",
    [
        ["rig"],
        ["rig", "face.npz", "--out", "rig.gltf"],
        ["rig", "face.npz", "--out", "rig.glb", "--neutral", "smiling"],
        ["animate", "rig.glb", "take.csv"],
        ["animate", "rig.glb", "take.csv", "--video", "a.avi"],
        ["animate", "rig.glb", "take.csv", "--out", "a.glb", "--scale", "jawOpen"],
        ["animate", "rig.glb", "take.csv", "--out", "a.glb", "--view", "profile"],
        ["animate", "rig.glb", "take.csv", "--frames", "d", "--size", "64"],
        ["retarget", "b.npz", "smile.obj", "--out", "a.obj", "--fps", "30"],
        ["stylise", "p.png", "--out", "a.png", "--shape", "none", "--strength", "2"],
        ["stylise", "p.png", "--out", "a.png", "--shape", "none", "--model", "pca"],
        ["stylise", "p.png", "--out", "a.png", "--timeout", "3"],
        ["stylise", "p.png", "--out", "a.png", "--landmarks", "m.json", "--detector", "d.safetensors"],
        ["studio", "--replay", "s.json", "--out", "a.obj", "--port", "0"],
        ["reconstruct-from-sketch", "s.json", "--out", "a.obj", "--coarse", "model", "--network", "n.safetensors"],
        *(
            ["texture", "f.npz", "p.png", "--out", "d", "--project-uv", *more]
            for more in (["--size", "512"], ["--keep-light"], ["--hair", "shell"])
        ),
        *(
            [*words, *idle]
            for words in (
                ["reconstruct-from-landmarks", __file__, "--out", "a.obj"],
                ["refine", "f.npz", __file__, "--out", "a.obj"],
                ["fit-morphable", __file__, "--out", "a.obj"],
                ["blendshapes", __file__, "--out", "b.npz"],
                ["retarget", "b.npz", __file__, "--out", "a.obj"],
            )
            for idle in (["--detector", "d.safetensors"], ["--pts-origin", "0"])
        ),
        ["render", "face.npz", "-o", "a.png", "--views", "above"],
        ["render", "face.npz", "-o", "a.png", "--size", "4096", "--views", "turntable", "--frames", "360"],
        ["render", "a.npz", "b.npz", "-o", "a.png", "--image", "c.png"],
        ["reconstruct-from-landmarks", "a.json"],
        ["edit-handle", "face.npz", "--handle", "nose_tip", "--out", "a.obj"],
        ["edit-handle", "face.npz", "--handle", "nose_tip=1,2", "--out", "a.obj"],
        ["edit-handle", "face.npz", "--out", "a.obj"],
        ["edit-semantic", "face.npz", "--label", "BigNose", "--out", "a.obj"],
        ["train", "pca", "--data", "d", "--out", "model.npz"],
        ["train", "pca", "--data", "d", "--out", "m.safetensors", "--set", "dimension"],
        ["train", "pca", "--data", "d", "--out", "m.safetensors", "--set", "dimensions=3"],
        ["train", "pca", "--data", "d", "--out", "m.safetensors", "--set", "dimension=0"],
        ["template", "export", "head.txt"],
        ["template", "export", "head.obj", "--size", "512"],
        ["edit-handle", "f.npz", "--handle", "chin=0,0,1%", "--out", "a.obj", "--no-picture", "--steps", "3"],
        ["edit-handle", "f.npz", "--handle", "chin=0,0,1%", "--out", "a.obj", "--no-picture", "--baseline", "arap"],
        ["edit-semantic", "f.npz", "--label", "BigNose=1", "--out", "a.obj", "--no-picture", "--steps", "3"],
        ["edit-semantic", "f.npz", "--list"],
        ["edit-semantic", "--list", "--label", "BigNose=1"],
        ["caricaturize", "f.npz", "--out", "a.obj", "--pts-origin", "0"],
        ["studio", "f.npz", "--no-picture"],
        ["studio", "f.npz", "--overwrite"],
        ["stylise", "p.png", "--out", "a.png", "--pts-origin", "0"],
        ["portrait", "p.png", "--out-dir", "d", "--pts-origin", "0"],
        ["animate", "rig.glb", "take.csv", "--out", "a.glb", "--format", "obj"],
        ["dataset", "build", "d", "--albedo-size", "64"],
        ["dataset", "show", "d", "--faces", "3"],
        ["evaluate", "detector", "--pictures", "d", "--out", "e", "--pts-origin", "0"],
        ["evaluate", "portrait", "--data", "d", "--out", "e", "--pts-origin", "0"],
    ],
)
def test_wrong_usage_is_one_line_and_2_everywhere(refused, args, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(*args, code=2)
    assert list(tmp_path.iterdir()) == []


def test_what_is_wrong_in_the_files_is_1(refused, tmp_path):
    config = tmp_path / "config.yaml"
    config.write_text("dimension: 0\n")
    out = ("--out", tmp_path / "m.safetensors")
    assert "dimension" in refused("train", "pca", "--data", tmp_path, *out, "--config", config)


def test_every_command_that_writes_says_how_long_it_took():
    says = re.compile(r"echo_result\(|run_batch\(|train_and_write\(")
    for module, _, _ in COMMANDS.values():
        if module:
            text = FOLDER.joinpath(*module.split(".")).with_suffix(".py").read_text("utf-8")
            assert "out_option" not in text and "overwrite_option" not in text or says.search(text), module
