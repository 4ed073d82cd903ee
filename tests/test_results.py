import re
import shlex
import subprocess

import pytest

from benchmarks import results
from caricli.cli import COMMANDS

RUNS, TABLES = results.registry()
PAGE = results.PAGE.read_text("utf-8")


def test_tables_are_those_of_their_figures():
    assert results.rendered(PAGE) == PAGE, "run: python -m benchmarks.results --render"


def test_a_changed_figure_changes_its_table(monkeypatch):
    def other(run):
        told = results_of(run)
        return told | {"revision": "0000000"} if run == "shape" else told

    results_of = results.figures_of
    monkeypatch.setattr(results, "figures_of", other)
    assert results.rendered(PAGE) != PAGE


def test_every_table_of_the_page_has_its_command_and_every_table_that_is_told_is_there():
    assert sorted(match[1] for match in results.MARKED.finditer(PAGE)) == sorted(TABLES)
    assert not re.search(r"^\|", results.MARKED.sub("", PAGE), re.M), "a table without a command"
    assert {table.run for table in TABLES.values()} - {None} == set(RUNS)
    assert {path.stem for path in results.FOLDER.iterdir()} == set(RUNS)


@pytest.mark.parametrize("name", RUNS)
def test_figures_say_what_they_come_from(name):
    told = results.figures_of(name)
    assert set(told) == {"command", "revision", "date", "figures"}
    assert told["command"] == RUNS[name].command
    assert re.fullmatch(r"[0-9a-f]{7}\+?", told["revision"]) and re.fullmatch(r"20\d\d-\d\d-\d\d", told["date"])
    assert set(told["figures"]) == {table.rows for table in TABLES.values() if table.run == name}


@pytest.mark.parametrize("name", [name for name, run in RUNS.items() if run.short])
def test_short_runs_are_commands_of_this_project(name):
    words = shlex.split(RUNS[name].command)
    if words[0] == "caricli":
        assert " ".join(words[1:3]) in COMMANDS or words[1] in COMMANDS
    else:
        assert words[0] == "python" and (results.ROOT / words[1]).is_file()


def test_rows_print_what_they_hold_and_nothing_where_it_is_missing():
    table = results.Table("run", "rows", {"of": "{name}", "error": "{test[error]:.2f} %", "paper": "{paper}"})
    rows = {"one": {"test": {"error": 1.234}}, "two": {"test": None, "paper": None}}
    printed = results.markdown(results.Table(**vars(table) | {"beside": {"one": {"paper": 3}, "three": {}}}), rows)
    assert printed.splitlines()[2:] == ["| one | 1.23 % | 3 |", "| two | | |", "| three | | |"]


def test_all_figures_together_are_one_row_or_rows_by_name():
    whole = results.Table("run", ".", {"right": "{right:.1f}"})
    assert results.markdown(whole, {"right": 99.19, "confusion": {"a": 1}}).splitlines()[2:] == ["| 99.2 |"]
    each = results.Table("run", ".", {"": "{name}", "flips": "{flips}"}, where="flips")
    assert results.markdown(each, {"a": {"flips": 2}, "b": {"time": 1}}).splitlines()[2:] == ["| a | 2 |"]


def test_what_cannot_be_measured_is_said(monkeypatch):
    monkeypatch.delenv("CARICLI_REAL_DATA", raising=False)
    told = [results.Table("x", "rows", {"error": "{error}"})]
    drawings = results.Run("python x.py", needs=("draws", "$CARICLI_REAL_DATA"))
    assert results.why_not(drawings, told) == "left as it is without $CARICLI_REAL_DATA"
    assert "as it was printed" in results.why_not(results.Run("python x.py"), [*told, results.Table("x", "rows")])
    assert results.why_not(results.Run("python x.py"), told) is None


def test_a_run_keeps_the_figures_that_tables_show(monkeypatch, tmp_path):
    script = tmp_path / "x.py"
    figures = {"rows": [{"name": "a", "error": 0.123456789}], "more": 1, "deep": {"down": {"all": 2}}}
    script.write_text(f"import json; print('a table'); print(json.dumps({figures}))")
    monkeypatch.setattr(results, "FOLDER", tmp_path)
    results.measure("x", results.Run(f"python {script}"), {"rows", "deep.down"})
    told = results.figures_of("x")
    assert (
        told["figures"] == {"rows": [{"name": "a", "error": 0.123457}], "deep.down": {"all": 2}}
        and told["revision"] == results.revision()
    )


def test_short_tables_can_be_measured_from_a_clone():
    short = {name for name, run in RUNS.items() if run.short}
    assert short
    for table in TABLES.values():
        if table.run in short:
            assert table.columns and not any(need.startswith("$") for need in RUNS[table.run].needs)


def test_all_that_runs_need_has_a_command():
    makers = results.makers()
    for run in RUNS.values():
        for need in run.needs:
            assert need.startswith("$") or makers[need][1].startswith("caricli ")
    words = {word for run in RUNS.values() for word in run.command.split()}
    words |= {word for name, (_, command) in makers.items() for word in command.split() if word != name}
    assert {name for name, (path, _) in makers.items() if path.parent == results.ROOT} <= words


def test_what_a_run_needs_is_made_once_and_a_run_that_fails_does_not_stop_the_others(monkeypatch, tmp_path):
    calls = []

    def call(command):
        calls.append(command)
        if "bad" in command:
            raise subprocess.CalledProcessError(1, command)
        (tmp_path / "people").mkdir(exist_ok=True)
        return '{"rows": []}'

    runs = {name: results.Run(f"python {name}.py", needs=("people",)) for name in ("bad", "good")}
    tables = {name: results.Table(name, "rows", {"error": "{error}"}) for name in runs}
    page = tmp_path / "RESULTS.md"
    page.write_text("none")
    for name, value in {
        "_call": call,
        "registry": lambda: (runs, tables),
        "makers": lambda: {"people": (tmp_path / "people", "caricli dataset build people")},
        "FOLDER": tmp_path,
        "PAGE": page,
    }.items():
        monkeypatch.setattr(results, name, value)
    monkeypatch.setattr("sys.argv", ["results", "bad", "good"])
    with pytest.raises(SystemExit, match=r"bad: .*bad\.py"):
        results.main()
    assert calls == ["caricli dataset build people", "python bad.py", "python good.py"]
    assert (tmp_path / "good.json").is_file() and not (tmp_path / "bad.json").exists()
