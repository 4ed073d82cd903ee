"""caricli studio: drawing, placing and pulling on a page of one's own machine."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    WholeRange,
    named_mesh,
    out_option,
    overwrite_option,
    refuse_typed,
)
from caricli.commands.shared.picture import picture_option
from caricli.commands.shared.studio_run import replay_session, serve_studio
from caricli.errors import shown


@click.command()
@click.argument("start", required=False, type=PATH, metavar="[FACE.npz|PICTURE|FOLDER|SKETCH]")
@click.option("--port", type=WholeRange(0, 65535), default=8020, metavar="N", help="Serve here; 0 takes any free port.")
@click.option(
    "--host",
    default="127.0.0.1",
    metavar="NAME",
    help="Serve others, too, under this name or address, who need the token in the address that is printed.",
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option("--replay", type=PATH, metavar="SESSION.json", help="Do a session again without a page, for --out.")
@out_option("FACE.obj", f"Write the face of --replay here, {FACE_FILES}", required=False, check=named_mesh)
@picture_option
@overwrite_option
def command(start, port, host, no_browser, replay, out, overwrite):
    """Draw a face, and change it by hand, on a page in your browser.

    The page comes from this machine alone, and nobody sees it but who knows the address that is printed, which ends in
    a token of yours. It needs caricli[studio].
    What it saves as a session makes the same bytes with --replay; the file that the session began with is looked for
    beside it where it is not given. Of a FOLDER of pictures the landmarks are placed, one picture after the other, from
    the first that has no landmark file beside it.

    \b
    Example:
      caricli studio face.npz
      caricli studio drawings
      caricli studio drawing.png --no-browser
      caricli studio --replay session.json --out face.obj
    """
    if (replay is None) != (out is None):
        raise click.UsageError("--replay and --out belong together.")
    if replay is not None:
        refuse_typed(
            "--replay serves no page: --host, --port and --no-browser are of it.", "host", "port", "no_browser"
        )
        count = replay_session(replay, start, out, overwrite)
        echo_result(f"{shown(out)}: {count} operations")
    else:
        refuse_typed("--overwrite and --no-picture are of --replay.", "overwrite", "picture")
        serve_studio(start, host, port, not no_browser)
