"""Serving the studio, and replaying its sessions."""

import socket
import webbrowser
from collections import deque
from importlib.util import find_spec
from pathlib import Path

import click

from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.picture import SIZE, write_picture
from caricli.errors import CaricliError, UsageError, naming
from caricli.io.provenance import provenance
from caricli.io.session import read_session
from caricli.io.strict_json import write_json
from caricli.structures.frame import AXES, UNITS


def replay_session(path: Path, start: Path | None, out: Path, overwrite: bool) -> int:
    """Do a session again and write its face. path: of it. start: the file that it began with, or None for the one
    beside it. out: mesh. Returns the number of operations. Raises CaricliError.
    """
    from caricli.methods.faces.draw_face import FaceDrawing
    from caricli.methods.session.pose import Poser
    from caricli.methods.session.replay import replay
    from caricli.render.sheets.contact_sheet import contact_sheet
    from caricli.store.face_files import write_face_files
    from caricli.store.session_tools import SessionTools, find_start, load_start
    from caricli.template.fine_mesh import fine_mesh

    session = read_session(path)
    source = find_start(path, session.start, start)
    with staged_face(out, overwrite, [path, source], "replaying") as (mesh, npz, report, picture):
        tools = SessionTools()
        begun = load_start(source, tools)
        with naming(path):
            work = deque((begun, *replay(begun, session.operations, tools)), 1).pop()
            face = Poser(tools).face(work)
        write_face_files(mesh, npz, face)
        about = {"operations": len(session.operations), "units": UNITS, "axes": AXES}
        write_json(report, provenance("studio", [path, source]) | about)
        drawing = FaceDrawing(tools.model, fine_mesh(tools.model.template, 0), SIZE)
        write_picture(picture, lambda: contact_sheet(drawing.draw(face)))
    return len(session.operations)


def serve_studio(start: Path | None, host: str, port: int, browser: bool) -> None:
    """Serve the page until a signal ends it.

    start: what it begins with, or None. host: name or address. port: 0 for any free one. browser: whether one is
    opened. Raises CaricliError.
    """
    if find_spec("nicegui") is None:
        raise CaricliError("the page needs NiceGUI, which is not installed: pip install 'caricli[studio]'")
    from caricli.store.session_tools import SessionTools
    from caricli.store.studio_token import private_link, studio_token
    from caricli.studio.page import studio_page
    from caricli.studio.server import Address, Studio, serve, studio_app

    place = _listening(host, port)
    address = Address(host, place.getsockname()[1], studio_token())
    tools = SessionTools()
    studio = Studio(tools, start)

    def started() -> None:
        click.echo(address.url)
        if browser:
            webbrowser.open(private_link(address.url))

    serve(studio_app(studio, studio_page(studio), address.token), place, started)


def _listening(host: str, port: int) -> socket.socket:
    """A socket that nobody else takes while the page is made, of a free port in the place of 0.

    Raises UsageError where the port is taken or the host is none of ours.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        # Where Python says the address again, the reason alone.
        reason = (getattr(error, "strerror", None) or "no such address").partition(" (while")[0]
        raise UsageError(f"--host {host} --port {port}: cannot be served from: {reason}") from None
