import json
import os
import re
import signal
import subprocess
import sys
import types
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import caricli
from caricli.cli import COMMANDS, cli
from caricli.errors import CaricliError, InputError, NumericsError, OutputError
from caricli.io.meshes.obj import read_obj

ROOT = Path(caricli.__file__).parents[1]
# What reads arrays, pictures or meshes; none of it is needed to say what caricli can do.
HEAVY = "anny cv2 igl matplotlib numpy PIL rich safetensors scipy skimage sklearn torch trimesh warp yaml".split()


def environment():
    return os.environ | {"PYTHONPATH": str(ROOT)}


@pytest.fixture
def fails(monkeypatch):
    """A command that raises what it is told to, in the real group; returns the result of a run."""

    def run(error, *flags):
        @click.command
        def command():
            raise error

        monkeypatch.setitem(COMMANDS, "fail", ("fail", "Look", "Fails."))
        monkeypatch.setitem(sys.modules, "caricli.commands.fail", types.SimpleNamespace(command=command))
        return CliRunner().invoke(cli, [*flags, "fail"])

    return run


def script(body, **options):
    """Start a process that runs `body` as the body of a command `act`."""
    code = f"""
import os, signal, sys, time, types
from pathlib import Path
import click
from caricli import cli
@click.command
def command():
{"".join("    " + line + chr(10) for line in body.splitlines())}
cli.COMMANDS["act"] = ("act", "Look", "Acts.")
sys.modules["caricli.commands.act"] = types.SimpleNamespace(command=command)
cli.cli.main(["act"])
"""
    return subprocess.Popen([sys.executable, "-c", code], env=environment(), text=True, **options)


def test_help_lists_every_command_in_its_section():
    result = CliRunner().invoke(cli, ["--help"])
    assert result.exit_code == 0
    for name, (_, section, short_help) in COMMANDS.items():
        if " " not in name:
            block = re.search(rf"^{section}:\n((?:  .*\n?)+)", result.output, re.M)
            assert re.search(rf"^  {name} +{re.escape(short_help)}$", block[1], re.M)


def test_help_of_a_group_lists_its_commands():
    result = CliRunner().invoke(cli, ["dataset", "--help"])
    assert result.exit_code == 0
    for name in ("build", "import", "show"):
        assert f"  {name}" in result.output


def test_sections_stay_together():
    sections = [section for _, section, _ in COMMANDS.values()]
    assert len(set(sections)) == 1 + sum(a != b for a, b in zip(sections, sections[1:], strict=False))


def test_every_command_of_the_table_exists_and_every_module_is_in_the_table():
    modules = {module for module, _, _ in COMMANDS.values() if module}
    folder = ROOT / "caricli" / "commands"
    files = [path for path in folder.rglob("*.py") if re.search(r"^def command\(", path.read_text("utf-8"), re.M)]
    assert {".".join(path.relative_to(folder).with_suffix("").parts) for path in files} == modules


def test_modules_are_named_as_commands_are_typed():
    for name, (module, _, _) in COMMANDS.items():
        if module:
            assert module.removesuffix("_") == name.replace(" ", ".").replace("-", "_")


@pytest.mark.parametrize("args", [["--help"], ["--version"], ["dataset", "--help"]])
def test_help_imports_nothing_heavy(args):
    code = f"""
import sys
from caricli.cli import cli
try:
    cli.main({args})
except SystemExit as end:
    assert end.code == 0
loaded = {{name.partition(".")[0] for name in sys.modules}} & set({HEAVY})
commands = [name for name in sys.modules if name.startswith("caricli.commands.")]
print(sorted(loaded), commands, file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=True)
    assert done.stderr == "[] []\n"


def test_fits_and_rigs_import_nothing_that_takes_seconds():
    code = """
import sys
import caricli.commands.shared.landmark_batch, caricli.methods.reconstruct.fit_landmarks
import caricli.methods.rig.make_rig, caricli.methods.expressions.find_neutral, caricli.methods.texture.paint_head
import caricli.store.expression_tools, caricli.store.faces
print(sorted({"anny", "matplotlib", "skimage", "sklearn", "torch", "trimesh"} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=True)
    assert done.stdout == "[]\n"


def test_version():
    assert CliRunner().invoke(cli, ["--version"]).output == f"caricli, version {caricli.__version__}\n"


def test_module_and_group_are_the_same():
    done = subprocess.run(
        [sys.executable, "-m", "caricli", "--version"], capture_output=True, text=True, env=environment(), check=True
    )
    assert done.stdout == f"caricli, version {caricli.__version__}\n"


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (["no-such-command"], "No such command 'no-such-command'"),
        (["dataset", "no-such-command"], "No such command 'no-such-command'"),
        (["--no-such-option"], "No such option"),
        ([], "Usage: caricli"),
        (["dataset"], "Usage: caricli dataset"),
    ],
)
def test_wrong_usage_is_2(args, expected):
    result = CliRunner().invoke(cli, args)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert expected in result.stderr
    if not expected.startswith("Usage"):
        assert result.stderr.startswith("caricli: error: ") and result.stderr.count("\n") == 1
        assert f"; see caricli{' dataset' if args[0] == 'dataset' else ''} --help" in result.stderr


@pytest.mark.parametrize("args", [["no-such-command"], ["--no-such-option"], [], ["dataset"]])
def test_wrong_usage_as_json(args):
    result = CliRunner().invoke(cli, ["--json-errors", *args])
    assert result.exit_code == 2
    assert json.loads(result.stderr)["error"] == "usage"


@pytest.mark.parametrize(
    ("error", "kind", "message"),
    [
        (CaricliError("it failed"), "caricli", "it failed"),
        (InputError("a.obj: expected vertices, found none"), "input", "a.obj: expected vertices, found none"),
        (OutputError("a.obj exists"), "output", "a.obj exists"),
        (NumericsError("singular"), "numerics", "singular"),
        (InputError("a\nb\x1b[31m.obj: bad"), "input", "a b\\x1b[31m.obj: bad"),
        (OSError(28, "No space left on device", "a.obj"), "system", "a.obj: No space left on device"),
        (OSError(5, "Input/output error"), "system", "Input/output error"),
        (MemoryError(), "memory", "out of memory"),
        (click.ClickException("refused"), "failed", "refused"),
    ],
)
def test_failure_is_one_line_and_1(fails, error, kind, message):
    result = fails(error)
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr == f"caricli: error: {message}\n"
    result = fails(error, "--json-errors")
    assert result.exit_code == 1
    assert json.loads(result.stderr) == {"error": kind, "message": message}


@pytest.mark.parametrize("error", [ValueError("x\ny"), EOFError("cut off"), RecursionError("deep"), OSError("odd")])
def test_unexpected_failure_is_one_line_that_says_it_is_a_bug(fails, error):
    result = fails(error)
    assert result.exit_code == 1
    assert re.fullmatch(r"caricli: error: unexpected .*a bug in caricli.*--debug.*\n", result.stderr)
    assert " ".join(str(error).split()) in result.stderr


def test_debug_shows_the_traceback_and_ends_with_the_line(fails):
    result = fails(InputError("bad"), "--debug")
    assert result.exit_code == 1
    assert result.stderr.startswith("Traceback")
    assert result.stderr.endswith("\ncaricli: error: bad\n")
    assert "Traceback" in json.loads(fails(InputError("bad"), "--debug", "--json-errors").stderr)["traceback"]


def test_exit_code_given_by_a_command_is_kept(fails):
    assert fails(click.exceptions.Exit(0)).exit_code == 0
    assert fails(click.exceptions.Exit(1)).exit_code == 1


def test_interrupt_without_a_handler_is_130(fails):
    assert fails(KeyboardInterrupt()).exit_code == 130


def test_handlers_are_restored(fails):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    fails(InputError("bad"))
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("times", [1, 2])
def test_signal_removes_what_is_half_written(tmp_path, number, code, times):
    body = f"""
from caricli.io.outputs import staged
with staged(Path({str(tmp_path)!r}) / "new" / "face.obj") as (path,):
    path.write_text("half")
    print("ready", flush=True)
    time.sleep(60)
"""
    process = script(body, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == "ready\n"
    assert [path for path in tmp_path.rglob("*") if path.is_file()]
    for _ in range(times):
        process.send_signal(number)
    _, stderr = process.communicate(timeout=30)
    assert process.returncode == code
    assert stderr == f"caricli: error: stopped by {number.name}\n"
    assert list(tmp_path.iterdir()) == []


def test_sigterm_ends_a_run_with_worker_processes():
    # A worker says that it runs: a signal that meets it while it is being forked is lost in CPython.
    # One that comes just before a sleep does not end it: short ones.
    body = """
import multiprocessing
def doze():
    for _ in range(600):
        time.sleep(0.1)
def work():
    os.write(1, b"works\\n")  # at once, so that two workers do not mix
    doze()
workers = [multiprocessing.get_context("fork").Process(target=work, daemon=True) for _ in range(2)]
for worker in workers:
    worker.start()
os.write(1, b"ready\\n")
doze()
"""
    process = script(body, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    # A parent that is stopped before it knows of a worker leaves it behind.
    assert sorted(process.stdout.readline() for _ in range(3)) == ["ready\n", "works\n", "works\n"]
    process.send_signal(signal.SIGTERM)
    _, stderr = process.communicate(timeout=30)  # also waits for the workers, which hold the pipes
    assert process.returncode == 143
    assert stderr == "caricli: error: stopped by SIGTERM\n"


def test_reader_that_left_is_no_error():
    read_end, write_end = os.pipe()
    os.close(read_end)
    try:
        process = script("print('x' * 100000)", stdout=write_end, stderr=subprocess.PIPE)
    finally:
        os.close(write_end)
    _, stderr = process.communicate(timeout=30)
    assert stderr == ""
    assert process.returncode == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_full_disk_under_stdout_is_one_line(monkeypatch, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    with open("/dev/full", "w") as full:
        process = script("print('x')", stdout=full, stderr=subprocess.PIPE)
        _, stderr = process.communicate(timeout=30)
    assert process.returncode == 1
    assert stderr == "caricli: error: No space left on device\n"


@pytest.mark.parametrize("arguments", ["--help", "--version", "edit-semantic --list", "template export head.obj"])
def test_streams_that_are_closed(tmp_path, arguments):
    """What cannot be printed is said in one line; nothing is printed into a file that was opened meanwhile."""
    command = f"{sys.executable} -m caricli {arguments}"

    def run(streams):
        done = subprocess.run(
            ["sh", "-c", f"{command} {streams}"], cwd=tmp_path, env=environment(), capture_output=True
        )
        for path in tmp_path.glob("head.obj"):
            assert len(read_obj(path).vertices) == 4200
            path.unlink()
        return done.returncode, done.stderr.decode()

    assert run(">&-") == (1, "caricli: error: standard output is closed\n")
    assert run("2>&- > /dev/null") == (0, "")
    assert run(">&- 2>&- <&-") == (1, "")


def test_the_entry_point_runs_the_group():
    code = "from caricli.__main__ import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "--version"], capture_output=True, text=True, env=environment())
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("caricli, version")
