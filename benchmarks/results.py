"""Every table of RESULTS.md from the figures of a command: python -m benchmarks.results [--long] [--render] [NAME...].

tables.yaml says by which command figures come, and how their tables are printed. Its short runs are done where nothing
else is said, with --long the others, else those that are named; a run whose figures are of the present revision is not
done again, so that one may be stopped and goes on with the next. Tables that have no columns there hold figures as they
were printed before they were kept, and stay as they are until tables.yaml says how to print them. The figures go to
results/NAME.json with command, revision and date, and all tables are rendered between their markers in RESULTS.md,
`<!-- table: NAME -->` and `<!-- end -->`; --render does only that. The test set (configs/testset.yaml) and what else a
run needs are made where they are not there. A run that fails does not stop the others.
"""

import argparse
import datetime
import functools
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "benchmarks" / "RESULTS.md"
FOLDER = ROOT / "benchmarks" / "results"
TESTSET = ROOT / "testset"
MARKED = re.compile(r"<!-- table: (\S+) -->\n(.*?)<!-- end -->", re.S)
BUNDLED = re.compile(re.escape(f"{ROOT / 'caricli' / 'assets'}/") + r"(\w+)\.safetensors")
DIGITS = 6
"""Of figures that are written: more than any table prints."""


@dataclass(frozen=True)
class Table:
    """How the rows of a run are printed.

    rows: key of the figures under which they are, or keys with a "." between them, "." for all of them: a list of
    objects, objects by name, which becomes their "name", or one object, whose name is the last key.
    columns: by title what a cell holds, a format string over its row; without, rows are printed as they are. beside:
    by row's name what stands beside the figures, a paper's above all; the only rows where there is no run.
    where: key of which a row has to have something, other than 0, or it is left out.
    """

    run: str | None = None
    rows: str = ""
    columns: dict[str, str] | None = None
    beside: dict[str, dict] | None = None
    where: str | None = None


@dataclass(frozen=True)
class Run:
    """command: as typed at the root, its result the JSON file that it writes under OUT, else its last line.

    short: below two minutes, from a clone, and the same figures every time. needs: folders of the test set, and what
    tables.yaml says under "data", in the order in which they are made; those with a $ are variables of the environment,
    data that nobody may hand on.
    """

    command: str
    short: bool = False
    needs: tuple[str, ...] = ()


def told_of_tables() -> dict:
    """What tables.yaml holds."""
    return yaml.safe_load((ROOT / "benchmarks" / "tables.yaml").read_text("utf-8"))


def registry() -> tuple[dict[str, Run], dict[str, Table]]:
    """Runs and tables of tables.yaml by name."""
    told = told_of_tables()
    runs = {name: Run(**run) for name, run in told["runs"].items()}
    return runs, {name: Table(**table) for name, table in told["tables"].items()}


def figures_of(run: str) -> dict:
    """The JSON object of a run: command, revision, date, figures."""
    return json.loads((FOLDER / f"{run}.json").read_text("utf-8"))


def render(table: Table) -> str:
    """A table in Markdown, with a line that says where its figures come from."""
    if table.run is None:
        return markdown(table, [])
    told = figures_of(table.run)
    source = f"*`{told['command']}`, revision {told['revision']}, {told['date']}*"
    return f"{markdown(table, told['figures'][table.rows])}\n{source}\n"


def markdown(table: Table, part: dict | list) -> str:
    """The table of a part of a run's figures."""
    rows = list(_rows(table, part))
    if table.columns:
        lines = [[_cell(text, row) for text in table.columns.values()] for row in rows]
    else:
        lines = [[*row.values()] for row in rows]
    titles = [*(table.columns or rows[0])]
    return "\n".join([_line(titles), "|---" * len(titles) + "|", *map(_line, lines)]) + "\n"


def _line(cells: Iterable[str]) -> str:
    return "|" + "".join(f" {cell.strip()} |" if cell else " |" for cell in cells)


def _rows(table: Table, part: dict | list) -> Iterator[dict]:
    """Rows with what stands beside them; what has no figures here comes last."""
    named = part if isinstance(part, list) else [{"name": table.rows.split(".")[-1]} | part]
    if isinstance(part, dict) and all(isinstance(row, dict) for row in part.values()):
        named = [{"name": name} | row for name, row in part.items()]
    beside = dict(table.beside or {})
    for row in named:
        if table.where and not row.get(table.where):
            continue
        yield row | beside.pop(row.get("name"), {})
    for name, row in beside.items():
        yield {"name": name} | row


def _cell(text: str, row: dict) -> str:
    """A format string over a row; nothing where one of its values is missing."""
    try:
        cell = text.format_map(row)
        return "" if cell == "None" else cell
    except (KeyError, TypeError):
        return ""


def rendered(page: str) -> str:
    """The text of RESULTS.md with its tables as their figures say; those whose run was never done stay."""
    _, tables = registry()

    def block(match: re.Match) -> str:
        run = tables[match[1]].run
        if run and not (FOLDER / f"{run}.json").is_file():
            return match[0]
        return f"<!-- table: {match[1]} -->\n{render(tables[match[1]])}<!-- end -->"

    return MARKED.sub(block, page)


def revision() -> str:
    """The commit that figures are of; with a plus where files of the project differ from it."""

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    changed = git("status", "--porcelain", "--", "caricli", "configs", "benchmarks/*.py")
    return git("rev-parse", "--short=7", "HEAD") + ("+" if changed else "")


def is_present(name: str) -> bool:
    """Whether the figures of a run are of the present revision."""
    return (FOLDER / f"{name}.json").is_file() and figures_of(name)["revision"] == revision()


def measure(name: str, run: Run, parts: Iterable[str]) -> None:
    """Do a run and write its figures, those parts that tables show."""
    with tempfile.TemporaryDirectory() as folder:
        done = _call(run.command.replace("OUT", folder))
        files = list(Path(folder).rglob("*.json"))
        text = files[0].read_text("utf-8") if files else done.splitlines()[-1]
    told = json.loads(BUNDLED.sub(r"\1", text))
    figures = told if isinstance(told, dict) else {"rows": told}
    result = {
        "command": run.command,
        "revision": revision(),
        "date": datetime.date.today().isoformat(),
        "figures": {part: _rounded(_part(figures, part)) for part in sorted(parts)},
    }
    (FOLDER / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n", "utf-8")


def makers() -> dict[str, tuple[Path, str]]:
    """By name where that lies which runs need, and the command that makes it."""
    told = yaml.safe_load((ROOT / "configs" / "testset.yaml").read_text("utf-8"))
    testset = {name: (TESTSET / name, f"{command} --seed {told['seed']}") for name, command in told["folders"].items()}
    return testset | {name: (ROOT / name, command) for name, command in told_of_tables()["data"].items()}


def make_missing(needs: Iterable[str]) -> None:
    """Make what is missing of what a run needs."""
    for name in needs:
        if not name.startswith("$"):
            path, command = makers()[name]
            if not path.exists():
                _call(command)


def _call(command: str) -> str:
    """What a command prints; one thread, so that sums come out the same everywhere."""
    words = shlex.split(os.path.expandvars(command))
    start = {"caricli": [sys.executable, "-m", "caricli"], "python": [sys.executable]}[words[0]]
    environment = {"OMP_NUM_THREADS": "1"} | os.environ | {"PYTHONPATH": str(ROOT)}
    print(f"$ {command}", file=sys.stderr, flush=True)
    return subprocess.run(
        [*start, *words[1:]], cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=True
    ).stdout


def _part(figures: dict, rows: str) -> object:
    """What rows of a table are made of; of all figures those without words, such as a version."""
    if rows == ".":
        return {key: value for key, value in figures.items() if isinstance(value, int | float | dict)}
    return functools.reduce(dict.__getitem__, rows.split("."), figures)


def _rounded(value: object) -> object:
    """Figures with so many digits."""
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def why_not(run: Run, tables: Iterable[Table]) -> str | None:
    """Why a run cannot be done here; None where it can."""
    missing = [name for name in run.needs if name.startswith("$") and not os.environ.get(name[1:])]
    if missing:
        return f"left as it is without {', '.join(missing)}"
    if not all(table.columns for table in tables):
        return f"left as it was printed; tables.yaml does not say how to print what {run.command} gives"
    return None


def main() -> None:
    """Do runs and render the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--long", action="store_true", help="the long runs that are not of the present revision")
    parser.add_argument("--render", action="store_true", help="no run, only the tables")
    asked = parser.parse_args()
    runs, tables = registry()
    failed = []
    for name in asked.names or [name for name, run in runs.items() if run.short != asked.long and not asked.render]:
        own = [table for table in tables.values() if table.run == name]
        obstacle = why_not(runs[name], own)
        if obstacle:
            print(f"{name}: {obstacle}", file=sys.stderr)
        elif asked.names or not is_present(name):
            try:
                make_missing(runs[name].needs)
                measure(name, runs[name], {table.rows for table in own})
            except subprocess.CalledProcessError as error:
                failed.append(f"{name}: {error}")
            PAGE.write_text(rendered(PAGE.read_text("utf-8")), "utf-8")
    PAGE.write_text(rendered(PAGE.read_text("utf-8")), "utf-8")
    if failed:
        sys.exit("\n".join(failed))


if __name__ == "__main__":
    main()
