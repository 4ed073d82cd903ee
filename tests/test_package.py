import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import caricli
from caricli.io.bundled import asset_path, config_path

ROOT = Path(caricli.__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def files_below(folder):
    names = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {name.as_posix() for name in names if "__pycache__" not in name.parts}


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The wheel as `python -m build` makes it (by way of the source archive), unpacked into a folder of its own."""
    source, out, site = (tmp_path_factory.mktemp(name) for name in ("source", "out", "site"))
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for name in ("caricli", "configs"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(source)]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    (wheel,) = out.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


def run_installed(site, folder, *args):
    return subprocess.run(
        [sys.executable, *args],
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(site)},
        timeout=300,
    )


def test_wheel_holds_code_assets_and_configs_and_runs_alone(installed, tmp_path):
    packed = files_below(installed / "caricli")
    assert packed == files_below(ROOT / "caricli") | {f"configs/{name}" for name in files_below(ROOT / "configs")}
    assert any(name.startswith("assets/") for name in packed)
    assert any(re.fullmatch(r"configs/.+\.yaml", name) for name in packed)

    (info,) = installed.glob("*.dist-info")
    assert info.name == f"caricli-{caricli.__version__}.dist-info"
    assert "caricli = caricli.__main__:main" in (info / "entry_points.txt").read_text()
    assert (info / "licenses" / "LICENSE").exists()

    where = run_installed(installed, tmp_path, "-c", "import caricli; print(caricli.__file__)")
    assert Path(where.stdout.strip()) == installed / "caricli" / "__init__.py"
    shown = run_installed(installed, tmp_path, "-m", "caricli", "--help")
    assert (shown.returncode, shown.stderr) == (0, "")
    assert shown.stdout.startswith("Usage: caricli")

    code = "from caricli.io.bundled import config_path; print(config_path('README.md').exists())"
    found = run_installed(installed, tmp_path, "-c", code)
    assert found.stdout == "True\n"
    exported = run_installed(installed, tmp_path, "-m", "caricli", "template", "export", "head.obj")
    assert (exported.returncode, exported.stderr) == (0, "")
    assert (tmp_path / "head.obj").stat().st_size > 100_000


def test_bundled_files_are_found_in_a_checkout():
    assert asset_path("head_annotation.json").is_file()
    assert config_path("README.md").is_file()


def test_constraints_pin_every_dependency_exactly():
    lines = (ROOT / "constraints.txt").read_text("utf-8").split()
    pins = dict(re.fullmatch(r"([A-Za-z0-9._-]+)==([0-9][0-9a-z.]*)", line).groups() for line in lines)
    assert pins["torch"] == "2.13.0"
    wanted = PROJECT["dependencies"] + PROJECT["optional-dependencies"]["dev"]
    names = {canonical(re.match(r"[A-Za-z0-9._-]+", requirement)[0]) for requirement in wanted}
    assert names - {canonical(name) for name in pins} == set()


def test_the_minimum_python_is_the_one_that_is_promised():
    assert PROJECT["requires-python"] == ">=3.11"
