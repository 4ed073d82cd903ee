"""Many inputs in one call: one bad item does not stop the others."""

import click

from caricli.commands.loading import progress_bar
from caricli.errors import CaricliError


def run_batch(ctx, items, work, description):
    """Do the work for every item and say what came of it; failures end as a table and exit code 1.

    items: a list of tuples, the first entry the path that a failure is reported under. work: called with the entries of
    an item, returns the line to print. A single item fails as any command does.
    """
    failures = []
    with progress_bar(description) as report:
        for number, item in enumerate(items):
            try:
                click.echo(work(*item))
            except CaricliError as error:
                if len(items) == 1:
                    raise
                failures.append((item[0], error))
            report(number + 1, len(items))
    for path, error in failures:
        click.echo(f"caricli: failed: {path}: {error}", err=True)
    if failures:
        click.echo(f"caricli: {len(failures)} of {len(items)} failed", err=True)
        ctx.exit(1)
