import os
import re
import runpy
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote

import click
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image, ImageChops, ImageStat

import caricli
from caricli.cli import COMMANDS, cli
from caricli.io.meshes.mesh import read_mesh, write_mesh
from caricli.io.strict_json import read_json
from tests.reports import report_rows, untold_keys

ROOT = Path(caricli.__file__).parents[1]
ASSETS = ROOT / "caricli" / "assets"
NOT_OURS = re.compile(
    r"(^|/)(\.git|\.venv.*|__pycache__|node_modules|\..*_cache|\.hypothesis|.*\.egg-info|build|dist|demo)/"
)
# Places and addresses that exist on one machine only; no file of the project depends on them. Written so that this
# file does not hold them itself.
ONE_MACHINE = re.compile(
    r"(?<![\w.~$})/-])/(?:wor[k]|tm[p]|roo[t]|hom[e]|Users|op[t]|mn[t])/\w"
    r"|index-ur[l]|find-link[s]|pythonhoste[d]|pypi\.org/simpl[e]|download\.pytorc[h]"
)
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)|<(?:img|a)\b[^>]*?\b(?:src|href)=[\"']([^\"']+)", re.I)


def project_files():
    """The files of the project: what git would commit, or in an unpacked copy all that is not made by a tool."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(listing, cwd=ROOT, capture_output=True) if (ROOT / ".git").exists() else None
    if done is not None and done.returncode == 0:
        names = done.stdout.decode().split("\0")
    else:
        names = [path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*")]
    return [ROOT / name for name in names if name and not NOT_OURS.search(name) and (ROOT / name).is_file()]


def text_of(path):
    """The text of a file, or None where it is not one."""
    data = path.read_bytes()
    try:
        return None if b"\0" in data else data.decode()
    except UnicodeDecodeError:
        return None


def command_named(name):
    command, context = cli, click.Context(cli, info_name="caricli")
    for word in name.split():
        command = command.get_command(context, word)
        context = click.Context(command, info_name=word, parent=context)
    return command, context


COMMAND_NAMES = [name for name, (module, _, _) in COMMANDS.items() if module]


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_help_says_what_the_command_does_and_shows_it(name):
    command, context = command_named(name)
    assert isinstance(command, click.Command)
    text = command.get_help(context)
    # The block as it is printed, so that a missing \b, which would run its lines together, is seen.
    assert re.search(rf"^ +Example:\n +caricli {re.escape(name)} \S", text, re.M), text
    assert re.match(r"Usage: .*\n\n +[A-Z]", text), "no line that says what the command does"


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_every_option_has_help(name):
    command, _ = command_named(name)
    assert [option.name for option in command.params if isinstance(option, click.Option) and not option.help] == []


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_example_in_help_names_only_options_that_exist(name):
    command, context = command_named(name)
    known = {text for option in command.get_params(context) for text in (*option.opts, *option.secondary_opts)}
    example = command.get_help(context).partition("Example:\n")[2].partition("\nOptions:")[0]
    used = set(re.findall(r"(?<=\s)--?[a-z][a-z-]*", example))
    assert used <= known, used - known


def test_reference_is_current():
    done = subprocess.run(
        [sys.executable, str(ROOT / "docs" / "generate_cli.py"), "--check"],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(ROOT), "COLUMNS": "60"},
    )
    assert done.returncode == 0, done.stderr


def test_reference_has_every_command():
    sections = re.findall(r"^## caricli (.+)$", (ROOT / "docs" / "cli.md").read_text("utf-8"), re.M)
    assert sorted(sections) == sorted(COMMANDS)


HARNESS = runpy.run_path(str(ROOT / "benchmarks" / "output_hashes.py"))


def harness_lines(name):
    """The lines of benchmarks/output_hashes.py that run a command."""
    return [line for line in HARNESS["COMMANDS"] if f"{line} ".startswith(f"{name} ")]


def test_the_hashes_of_outputs_cover_every_command():
    unused = {name for name in COMMAND_NAMES if not harness_lines(name)}
    assert unused == set(HARNESS["LEFT_OUT"]), "each needs a line in COMMANDS, or in LEFT_OUT with its reason"


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_the_hashes_of_outputs_name_only_options_that_exist(name):
    command, context = command_named(name)
    known = {text for option in command.get_params(context) for text in (*option.opts, *option.secondary_opts)}
    used = set(re.findall(r"(?<=\s)--?[a-z][a-z-]*", "\n".join(harness_lines(name))))
    assert used <= known, used - known


def pages():
    return [path for path in project_files() if path.suffix == ".md"]


def broken_links(page, text):
    """The relative links and images of a Markdown page that lead nowhere."""
    text = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.S)
    targets = (a or b for a, b in LINK.findall(text))
    local = (unquote(t.partition("#")[0]) for t in targets if not re.match(r"[a-z][a-z+.-]*:", t, re.I))
    return [t for t in local if t and not (page.parent / t).exists()]


def test_links_of_every_page_lead_somewhere():
    broken = {str(page.relative_to(ROOT)): broken_links(page, page.read_text("utf-8")) for page in pages()}
    assert {page: links for page, links in broken.items() if links} == {}
    assert ROOT / "README.md" in pages()


def test_link_check_sees_what_is_broken(tmp_path):
    page = tmp_path / "README.md"
    page.touch()
    text = (
        '[a](gone.md) ![b](gone.png "title") <img width="9" src="gone.jpg"> [c](https://example.org/x) [d](#here)\n'
        "[e](README.md#part) `[f](code.md)`\n```\n[g](code.md)\n```\n[h](<gone.txt>)"
    )
    assert broken_links(page, text) == ["gone.md", "gone.png", "gone.jpg", "gone.txt"]


# Commands that write no report, and what they write.
NO_REPORT = {
    "map-landmarks": "landmarks",
    "dataset build": "a dataset with its manifest",
    "dataset import": "likewise",
    "dataset pictures": "a folder with its manifest",
    "dataset sketches": "likewise",
    "dataset textures": "likewise",
    "dataset show": "a picture",
    "template export": "a mesh",
    "render": "pictures",
    "sketch": "a drawing",
    "inspect": "nothing",
}


def test_every_report_is_described():
    assert set(COMMAND_NAMES) - set(report_rows()) == set(NO_REPORT), "each needs a row in docs/formats.md, Reports"


@pytest.mark.parametrize("path", sorted(ASSETS.glob("*.json")), ids=lambda path: path.stem)
def test_what_bundled_reports_hold_is_described(path):
    value = read_json(path)
    assert "command" not in value or untold_keys(value) == set()


def test_what_no_row_says_is_seen():
    # What all reports have, an option, a figure of its own, and one of the command that its row names.
    good = {"command": "fit-coarse", "inputs": {}, "parts": "skin", "coefficients": [], "nme": 1.0}
    assert untold_keys(good) == set() and untold_keys(good | {"nmes": 1.0, "label": 2}) == {"nmes", "label"}
    assert untold_keys({"command": "render", "nme": 1.0}) == {"nme"}


ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text("utf-8")


def floors():
    """What docs/architecture.md says of every folder of the package, by its name, in their order."""
    listed = ARCHITECTURE.partition("\ncaricli/\n")[2].partition("```")[0]
    entries = re.findall(r"^  (\w+)/\S*(.*(?:\n {3,}.*)*)", listed, re.M)
    return {name: " ".join(text.split()) for name, text in entries}


def folders(path):
    return {folder.name for folder in path.iterdir() if folder.is_dir() and folder.name != "__pycache__"}


def test_every_folder_of_the_package_is_a_floor():
    assert set(floors()) == folders(ROOT / "caricli")


def test_every_wing_is_named():
    wings = floors()["methods"].partition(": ")[2].split(", ")
    assert sorted(wing.split()[0] for wing in wings) == sorted(folders(ROOT / "caricli" / "methods"))


@pytest.mark.parametrize("floor", ["geometry", "io", "render", "studio"])
def test_every_room_is_named(floor):
    assert set(re.findall(r"(\w+)/", floors()[floor])) == folders(ROOT / "caricli" / floor)


def test_imports_point_as_they_are_told():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contract = project["tool"]["importlinter"]["contracts"][0]
    told = re.findall(r"\w+", re.search(r"`(errors ←[^`]*)`", ARCHITECTURE)[1])
    assert told[1:] == [layer for layer in reversed(contract["layers"]) if "|" not in layer and "__" not in layer]
    assert told[1:-1] == [name for name in floors() if name != "assets"]


def test_only_those_see_paths_of_whom_it_is_told():
    told = re.search(r"Only ([^.]*) see\s+paths", ARCHITECTURE)[1]
    sources = (ROOT / "caricli").glob("*/**/*.py")
    seeing = {path for path in sources if re.search(r"^\s*(?:from|import) pathlib", path.read_text("utf-8"), re.M)}
    assert set(re.findall(r"\w+(?=`)", told)) == {path.relative_to(ROOT / "caricli").parts[0] for path in seeing}


def test_the_new_command_of_contributing_runs_as_it_stands(head_template, tmp_path, monkeypatch):
    chapter = (ROOT / "CONTRIBUTING.md").read_text("utf-8").partition("## A new command\n")[2].partition("\n## ")[0]
    method, written = map(textwrap.dedent, re.findall(r"^ +```python\n(.*?)^ +```", chapter, re.M | re.S))
    module = ModuleType("caricli.methods.faces.mirror_face")
    exec(method, vars(module))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    names = {}
    exec(written, names)
    write_mesh(tmp_path / "face.obj", head_template.with_vertices(head_template.vertices + [0.01, 0, 0]))
    paths = [str(tmp_path / name) for name in ("face.obj", "mirrored.obj")]
    result = CliRunner().invoke(names["command"], [paths[0], "--out", paths[1]])
    assert result.exit_code == 0 and re.fullmatch(r".*mirrored\.obj: mirrored, .* s\n", result.output), result.output
    np.testing.assert_allclose(read_mesh(paths[1]).vertices, head_template.vertices - [0.01, 0, 0], atol=1e-4)


def test_every_asset_is_described():
    described = (ASSETS / "README.md").read_text("utf-8")
    files = [path for path in project_files() if path.is_relative_to(ASSETS) and path != ASSETS / "README.md"]
    assert files
    assert [path.name for path in files if path.name not in described] == []


def test_nothing_depends_on_one_machine():
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for path in project_files()
        if (text := text_of(path)) is not None
        for number, line in enumerate(text.splitlines(), 1)
        if ONE_MACHINE.search(line)
    ]
    assert found == []


@pytest.mark.parametrize("bad", ["cd /wor" + "k/main", "'/tm" + "p/x.obj'", "--extra-index-ur" + "l", "=/roo" + "t/a"])
def test_one_machine_check_sees_bad_lines(bad):
    assert ONE_MACHINE.search(bad)


@pytest.mark.parametrize("good", ["../shared/real", "https://example.org/home/x", "$HOME/work/x", "tmp_path / 'x'"])
def test_one_machine_check_passes_good_lines(good):
    assert not ONE_MACHINE.search(good)


def test_the_numbers_of_landmarks_are_drawn_by_their_script(tmp_path):
    script = ROOT / "docs" / "draw_landmarks.py"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, script, tmp_path / "landmarks.jpg"], check=True, env=environment)
    with (
        Image.open(tmp_path / "landmarks.jpg") as again,
        Image.open(ROOT / "docs" / "images" / "landmarks.jpg") as kept,
    ):
        difference = ImageChops.difference(again, kept)
        # Fonts of another machine differ a little.
        assert again.size == kept.size and max(ImageStat.Stat(difference).mean) < 3
