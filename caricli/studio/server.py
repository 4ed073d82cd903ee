"""The server of the page: its desks, what the page asks them for, and who may ask."""

import asyncio
import io
import socket
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Any, TypeVar

import numpy as np
import uvicorn
from fastapi import FastAPI, Request, Response
from nicegui import ui
from PIL import Image

from caricli.errors import CaricliError, InputError, shown
from caricli.io.image import is_image_file
from caricli.limits import MAX_IMAGE_BYTES
from caricli.methods.session.pull_basis import dressed_vertices
from caricli.methods.session.work import Work
from caricli.store.marked_folder import MarkedFolder
from caricli.store.session_tools import SessionTools, load_start, start_of
from caricli.studio.desk import Desk
from caricli.studio.guard import Guard

MOST_DESKS = 32
"""Tabs that are open at once; of more the oldest one ends, one that no browser shows where there is such."""

T = TypeVar("T")

_QUIET: dict[str, Any] = {"show_welcome_message": False, "reconnect_timeout": 20}
"""What NiceGUI says of itself, and seconds that it waits for a browser that is away."""


@dataclass(frozen=True)
class Address:
    """Where the page is. host: name or number. port: from 0. token: text that the page asks for."""

    host: str
    port: int
    token: str

    @property
    def url(self) -> str:
        """What is typed into a browser."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/?token={self.token}"


class Studio:
    """The desks of all tabs, and one thread that does what they ask, one after the other."""

    def __init__(self, tools: SessionTools, path: Path | None) -> None:
        """tools: SessionTools. path: what every tab begins with; a folder of pictures is gone through in the mode of
        landmarks, from the first that has none; or None. Raises InputError."""
        self.tools = tools
        self.mode = "draw"
        self.marked: MarkedFolder | None = None
        if path is not None and (path.is_dir() or is_image_file(path)):
            self.mode = "landmarks" if path.is_dir() else self.mode
            self.marked = MarkedFolder.of(path)
            path, work = _first_that_opens(self.marked, tools)
        else:
            work = load_start(path, tools)
        self.picture = path
        self.begun = work, start_of(path)
        self.desks: dict[str, Desk] = {}
        self.opened: dict[str, Callable] = {}
        self.here: dict[str, Callable[[], bool]] = {}
        self._thread = ThreadPoolExecutor(1)
        self._warm = False
        dressed_vertices(self.begun[0].face, tools)  # what holds parts is made now and not when a page waits for it

    async def run(self, function: Callable[..., T], *values: object) -> T:
        """Call a function in the thread. Raises what it raises."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, function, *values)

    def new_desk(self, here: Callable[[], bool]) -> Desk:
        """A desk for another tab. here: tells whether a browser shows it."""
        desk = Desk(self.tools, *self.begun)
        while len(self.desks) >= MOST_DESKS:
            away = (each for each in self.desks.values() if not self.here[each.key]())
            self.leave(next(away, next(iter(self.desks.values()))))
        self.desks[desk.key] = desk
        self.here[desk.key] = here
        return desk

    def warm(self) -> None:
        """Load what the first strokes need, once; before a page is there this would only keep it waiting."""
        if self._warm:
            return
        self._warm = True

        def load() -> None:
            for name in ("network", "templates", "reconstruction"):
                getattr(self.tools, name)

        Thread(target=load, daemon=True).start()

    def leave(self, desk: Desk) -> None:
        """A tab is gone."""
        for each in (self.desks, self.here, self.opened):
            each.pop(desk.key, None)


def _first_that_opens(folder: MarkedFolder, tools: SessionTools) -> tuple[Path, Work]:
    """The picture of a folder to begin with, and its Work; those that cannot be read are passed over.

    Raises InputError where none can be read.
    """
    refused = []
    for picture in folder.candidates(folder.first()):
        try:
            return picture, load_start(picture, tools)
        except InputError as error:
            refused.append(error)
    raise refused[0]


def studio_app(studio: Studio, page: Callable, token: str) -> FastAPI:
    """The application. page: builds the page of a tab. token: see ``Guard``."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    base = "/studio/{key}"

    @app.get(base + "/frame/{number}")
    async def frame(key: str, number: int) -> Response:
        return await _bytes(studio, key, Desk.frame)

    @app.get(base + "/layout/{number}")
    async def layout(key: str, number: int) -> Response:
        return await _bytes(studio, key, Desk.layout)

    @app.get(base + "/basis/{number}")
    async def basis(key: str, number: int) -> Response:
        return await _bytes(studio, key, lambda desk: desk.basis.astype("<f4").tobytes())

    @app.get(base + "/skin/{number}")
    async def skin(key: str, number: int) -> Response:
        return await _bytes(studio, key, lambda desk: _png(desk.work.face.pictures.skin), "image/png")

    @app.get(base + "/hair/{number}")
    async def hair(key: str, number: int) -> Response:
        return await _bytes(studio, key, lambda desk: _png(desk.work.face.pictures.hair), "image/png")

    @app.get(base + "/underlay/{number}")
    async def underlay(key: str, number: int) -> Response:
        return await _bytes(studio, key, lambda desk: _png(desk.work.picture), "image/png")

    @app.post(base + "/open")
    async def open_file(key: str, name: str, request: Request) -> Response:
        return await _opened(studio, key, name, request)

    ui.page("/")(page)
    ui.run_with(app, title="caricli studio", language="en-US", dark=None, **_QUIET)
    app.add_middleware(Guard, token=token)
    return app


def serve(app: FastAPI, place: socket.socket, started: Callable[[], None]) -> None:
    """Serve until a signal ends it. place: where, listening. started: called when the page can be asked for."""

    class Server(uvicorn.Server):
        async def startup(self, sockets: list | None = None) -> None:
            await super().startup(sockets)
            started()

    Server(uvicorn.Config(app, log_level="error", timeout_graceful_shutdown=1)).run([place])


async def _bytes(studio: Studio, key: str, make: Callable[[Desk], bytes | None], kind: str | None = None) -> Response:
    """What a desk makes, or that there is none."""
    desk = studio.desks.get(key)
    content = None if desk is None else await studio.run(make, desk)
    if content is None:
        return Response(status_code=404)
    return Response(content, media_type=kind or "application/octet-stream", headers={"Cache-Control": "no-store"})


def _png(pixels: np.ndarray | None) -> bytes | None:
    if pixels is None:
        return None
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG", compress_level=1)
    return stream.getvalue()


async def _opened(studio: Studio, key: str, name: str, request: Request) -> Response:
    """Give a file to the page of a desk, or say why it is refused."""
    opened = studio.opened.get(key)
    if opened is None:
        return Response("this page is closed", 404, media_type="text/plain")
    plain = Path(name.replace("\\", "/")).name
    if not plain or not plain.isprintable():
        return Response("expected a file with a name, found none", 400, media_type="text/plain")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / plain
        try:
            await _receive(request, path)
            await opened(path)
        except (CaricliError, OSError) as error:
            words = shown(error, 400).replace(f"{folder}/", "")
            return Response(words, 400, media_type="text/plain")
    return Response("")


async def _receive(request: Request, path: Path) -> None:
    """Write what is sent into a file. Raises CaricliError where it is too large."""
    size = 0
    with path.open("wb") as file:
        async for chunk in request.stream():
            size += len(chunk)
            if size > MAX_IMAGE_BYTES:
                raise CaricliError(f"{path.name}: expected at most {MAX_IMAGE_BYTES >> 20} MiB, found more")
            file.write(chunk)
