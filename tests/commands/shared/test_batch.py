from pathlib import Path

import click
from click.testing import CliRunner

from caricli.commands.shared.batch import run_batch
from caricli.errors import InputError


def test_what_failed_is_named_once():
    @click.command()
    @click.pass_context
    def command(ctx):
        def work(path, message):
            raise InputError(message)

        run_batch(
            ctx, [(Path("a.png"), "a.png: expected a face"), (Path("b.png"), "expected a face")], work, "pictures"
        )

    result = CliRunner().invoke(command)
    assert result.exit_code == 1
    assert "failed: a.png: expected a face\n" in result.stderr and "failed: b.png: expected a face\n" in result.stderr
