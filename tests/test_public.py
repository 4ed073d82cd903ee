"""The public library: what `import caricli` offers, how fast, and how it is typed."""

import inspect
import os
import re
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import numpy as np
import pytest

import caricli
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.landmarks import write_landmarks
from caricli.structures import Face, Material

ROOT = Path(caricli.__file__).parents[1]
ASTRONAUT = ROOT / "examples" / "astronaut"
PAGE = ROOT / "docs" / "python.md"
MODULES = [module.name for module in walk_packages(caricli.__path__, "caricli.") if not module.ispkg]
# Warp kernels are types of warp's own; commands are called by click alone.
UNTYPED = (
    "caricli.render.kernels",
    "caricli.render.visibility.raster_kernel",
    "caricli.commands.",
    "caricli.cli",
    "caricli.__main__",
)


def test_every_public_name_is_where_it_says():
    assert sorted(caricli.__all__) == sorted(caricli._HOME_OF)
    for name in caricli.__all__:
        assert getattr(caricli, name) is getattr(import_module(caricli._HOME_OF[name]), name)
        assert name in dir(caricli)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = caricli.nothing


def test_import_loads_nothing():
    code = (
        "import sys, caricli; print([name for name in sys.modules if name.startswith('caricli.') or name == 'numpy'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def public_functions():
    """Pairs of a name and a public function or method that is defined in a module of ours."""
    for module_name in MODULES:
        if module_name.startswith(UNTYPED):
            continue
        module = import_module(module_name)
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", None) != module_name:
                continue
            if inspect.isfunction(value):
                yield f"{module_name}.{name}", value
            elif inspect.isclass(value):
                for method_name, method in vars(value).items():
                    method = getattr(method, "__func__", getattr(method, "fget", method))
                    if inspect.isfunction(method) and not method_name.startswith("_"):
                        yield f"{module_name}.{name}.{method_name}", method


def test_public_functions_say_their_types():
    untyped = []
    for name, function in public_functions():
        signature = inspect.signature(inspect.unwrap(function))
        named = [p for p in signature.parameters.values() if p.name not in ("self", "cls")]
        if any(p.annotation is p.empty for p in named) or signature.return_annotation is signature.empty:
            untyped.append(name)
    assert untyped == []


def test_a_type_error_is_caught(tmp_path):
    good = "import caricli\n\nmesh = caricli.read_mesh('a.obj')\nprint(mesh.vertices.shape)\n"
    bad = good + "caricli.write_mesh('b.obj', mesh.vertices)\n"
    files = [str(tmp_path / "good.py"), str(tmp_path / "bad.py")]
    for file, text in zip(files, (good, bad), strict=True):
        Path(file).write_text(text)
    options = ["--config-file", str(ROOT / "pyproject.toml"), *files]
    done = subprocess.run([sys.executable, "-m", "mypy", *options], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 1 and "Found 1 error in 1 file (checked 2 source files)" in done.stdout, done.stdout
    assert "bad.py:5: " in done.stdout and 'expected "Mesh"' in done.stdout


def test_the_walk_of_the_page_makes_a_rig(tmp_path, head_template):
    """The first block of docs/python.md, as it stands, from landmarks to a rigged GLB."""
    (code,) = re.findall(r"<!-- tested -->\n+```python\n(.*?)```", PAGE.read_text("utf-8"), re.S)
    assert len([line for line in code.splitlines() if line.strip()]) <= 12
    fetch = [sys.executable, str(ASTRONAUT / "fetch_image.py"), str(tmp_path / "photo.png")]
    subprocess.run(fetch, check=True, capture_output=True)
    (tmp_path / "landmarks.json").write_bytes((ASTRONAUT / "landmarks.json").read_bytes())
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    rig = read_gltf(tmp_path / "rig.glb")
    assert len(rig.names) == 52 and rig.pictures.skin is not None and rig.pictures.skin.std() > 10
    # She has her hair, and her lips, apart in the photograph, meet.
    upper, lower = (rig.neutral[head_template.annotation.landmarks[k]] for k in (62, 66))
    assert rig.pictures.hair is not None and Material.HAIR in rig.materials
    assert np.linalg.norm(upper - lower) < 0.02 * head_template.height
    assert read_image(tmp_path / "photo.png").shape[2] == 3


@pytest.mark.parametrize("page", [PAGE, ROOT / "README.md"], ids=["python", "readme"])
def test_both_pages_leave_a_landmark_that_is_not_sure(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    marks = caricli.read_landmarks(ASTRONAUT / "landmarks.json")
    points = marks.points.copy()
    points[30] += [0, 40]  # the nose's tip, far below
    spreads = np.tile(np.eye(2), (len(points), 1, 1))
    spreads[30] *= 1e5
    write_landmarks(tmp_path / "landmarks.json", replace(marks, points=points, spreads=spreads))
    (code,) = re.findall(r"(landmarks = caricli.read_landmarks.*?\.face)\n", page.read_text("utf-8"), re.S)
    names: dict = {"caricli": caricli}
    exec(code.replace('picture = caricli.read_image("photo.png")', ""), names)
    face = names["face"]
    tip = face.camera.project(face.vertices[names["model"].template.annotation.landmarks[30]])
    assert np.linalg.norm(tip - marks.points[30]) < 10


def test_the_edits_of_the_page_move_a_nose(tmp_path, monkeypatch, head_template):
    """The blocks of docs/python.md after the first, as they stand."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.S)[1:]
    monkeypatch.chdir(tmp_path)
    caricli.write_face("face.npz", Face(head_template))
    names: dict = {}
    exec("".join(blocks), names)
    tip = head_template.annotation.landmarks[30]
    moved = names["pulled"].vertices - head_template.vertices
    np.testing.assert_allclose(moved[tip], [0, 0, 0.05 * head_template.height], atol=1e-4)
    assert caricli.read_mesh("edited.obj").vertices.shape == head_template.vertices.shape
