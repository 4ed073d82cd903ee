"""What docs/formats.md says of the reports of commands."""

import re
from functools import cache
from pathlib import Path

import click

import caricli
from caricli.cli import COMMANDS, cli

PAGE = Path(caricli.__file__).parents[1] / "docs" / "formats.md"


@cache
def report_rows():
    """The words in code of every command's row in the section on reports, by its name, and of what is of all as ""."""
    section = PAGE.read_text("utf-8").partition("\n## Reports\n")[2]
    about, _, table = section.partition("\n\n|")
    rows = {"": words(about)}
    for line in table.splitlines():
        names, _, keys = line.strip("| ").partition(" | ")
        rows |= {name: words(keys) for name in words(names) if name in COMMANDS}
    return rows


def words(text):
    return set(re.findall(r"`([^`]+)`", text))


def untold_keys(report):
    """Keys of a report that neither its row names, nor one that its row names, and that no option is called."""
    name = report["command"]
    rows = report_rows()
    own = rows.get(name, set())
    told = own.union(rows[""], *(rows[other] for other in own & rows.keys()))
    return set(report) - told - typed(name)


@cache
def typed(name):
    """What the options and arguments of a command are called."""
    command = cli
    for word in name.split():
        command = command.get_command(click.Context(command), word)
    return {text.lstrip("-").replace("-", "_") for option in command.params for text in (option.name, *option.opts)}
