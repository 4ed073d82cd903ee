"""Write docs/cli.md, the reference of all commands, from their help; with --check, only say whether it is current."""

import sys
from pathlib import Path

import click

from caricli.cli import cli

REFERENCE = Path(__file__).with_name("cli.md")
HEADING = """\
# The commands

Made from the help of each command by `make docs`; a test fails when it is not current.
"""


def walk(command: click.Command, name: str = "caricli", parent: click.Context | None = None):
    """Yield (what is typed, the command, its context) for `command` and everything below it."""
    # A fixed width, so that the terminal at hand has no say.
    context = click.Context(command, info_name=name, parent=parent, terminal_width=100, **command.context_settings)
    yield context.command_path, command, context
    if isinstance(command, click.Group):
        for child in command.list_commands(context):
            yield from walk(command.get_command(context, child), child, context)


def reference() -> str:
    """Return the text of docs/cli.md."""
    sections = [f"## {path}\n\n```text\n{command.get_help(context)}\n```\n" for path, command, context in walk(cli)]
    return "\n".join([HEADING, *sections])


if __name__ == "__main__":
    if "--check" not in sys.argv[1:]:
        REFERENCE.write_text(reference(), encoding="utf-8")
    elif not REFERENCE.exists() or REFERENCE.read_text(encoding="utf-8") != reference():
        sys.exit(f"{REFERENCE} is not current: run `make docs`")
