"""The page of one tab."""

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import ui
from nicegui.client import Client

from caricli.errors import CaricliError, InputError, shown
from caricli.io.files import read_start
from caricli.io.landmarks import landmarks_to_json, read_landmarks
from caricli.io.session import operation_to_json, read_session
from caricli.methods.session.gesture_operations import REDO, UNDO
from caricli.store.session_tools import lacks_materials
from caricli.structures import Operation
from caricli.studio.components import Head, Keep
from caricli.studio.desk import Desk
from caricli.studio.modes.draw_mode import DrawMode
from caricli.studio.modes.face_mode import FaceMode
from caricli.studio.modes.landmarks_mode import LandmarksMode
from caricli.studio.modes.mode import Mode
from caricli.studio.modes.redraw_mode import RedrawMode
from caricli.studio.modes.refine_mode import RefineMode
from caricli.studio.save import SAVED, saved
from caricli.studio.server import Studio

MODES: tuple[type[Mode], ...] = (DrawMode, RedrawMode, LandmarksMode, RefineMode, FaceMode)
"""In the order of their tabs."""

_STYLES = [Path(__file__).with_name(name) for name in ("studio.css", "landmark_canvas.css")]

_ENTERED = 0.2
"""Seconds until a panel is there."""

_IS_DARK = "() => emit(document.body.classList.contains('body--dark'))"
"""What a browser tells of how the page looks."""

SAVES = {
    "face": "Face: OBJ and NPZ",
    "rig": "Rig: GLB with 52 expressions",
    "picture": "Picture: PNG",
    "sketch": "Drawing: JSON",
    "landmarks": "Landmarks: JSON",
    "pts": "Landmarks: .pts of iBUG",
    "session": "Session: JSON, to be replayed",
}
"""What the menu calls what can be saved."""


class Page:
    """What one tab shows of its desk, and what it does with what a hand does.

    head: Head. desk: Desk. modes: a Mode for every tab.
    """

    def __init__(self, studio: Studio, desk: Desk) -> None:
        """studio: Studio that the desk belongs to."""
        self.studio = studio
        self.desk = desk
        self.base = f"/studio/{desk.key}"
        self._number = 0
        self._layout: object = None
        self._wanted: Operation | None = None
        self._busy = False
        self._bare = ""  # name of what was opened without its materials
        self.turn = asyncio.Lock()  # what is done is done in the order in which a hand did it
        self.heard = asyncio.Event()  # whether the browser has told what it kept

    def build(self) -> None:
        """Lay the page out."""
        ui.add_head_html(f"<style>{''.join(style.read_text('utf-8') for style in _STYLES)}</style>")
        self.dark = ui.dark_mode(None)
        self.keep = Keep(self.base, self.desk.start).on("returned", self._returned).on("opened", self._was_opened)
        self.keep.on("nothing", self.heard.set).on("undo", self.undo).on("redo", self.redo)
        self._header()
        with ui.element("main").classes("caricli-main"):
            with ui.tab_panels(self.tabs, value=self.studio.mode).classes("caricli-work") as panels:
                panels.props("transition-prev=fade transition-next=fade transition-duration=120 keep-alive")
                self.modes = [mode(self) for mode in MODES]
                for mode in self.modes:
                    with ui.tab_panel(mode.name).classes("caricli-panel"):
                        mode.build()
            with ui.element("section").classes("caricli-side").props('aria-label="The face"'):
                self.head = Head(self.base).on("ready", self._show_all)
                self._views()
                self.told = ui.label("").classes("caricli-told").props('role="status" aria-live="polite"')
        for mode in self.modes:
            mode.listen()
        self.tabs.on_value_change(lambda: ui.timer(_ENTERED, self._refresh_mode, once=True))

    def _refresh_mode(self, answered: int = 0) -> None:
        """Show the present in the open panel; those that nobody sees would only keep the head waiting."""
        for mode in self.modes:
            if mode.shown:
                mode.refresh(answered)

    def _header(self) -> None:
        with ui.element("header").classes("caricli-header"):
            ui.html("<h1>caricli studio</h1>", sanitize=False)
            with ui.tabs().props('dense aria-label="Modes"') as self.tabs:
                for mode in MODES:
                    ui.tab(mode.name, mode.label)
            with ui.element("div").classes("caricli-actions"):
                self.undo_button = _button("Undo", "undo", self.undo, "Ctrl+Z")
                self.redo_button = _button("Redo", "redo", self.redo, "Ctrl+Y")
                _button("New", "note_add", self._new, "an empty canvas")
                _button("Open", "folder_open", lambda: self.keep.run_method("choose"), "Ctrl+O")
                with ui.button("Save", icon="save").props("flat dense no-caps"), ui.menu().props("auto-close"):
                    for kind, words in SAVES.items():
                        item = ui.menu_item(words, on_click=partial(self._save, kind))
                        item.props(f'role="menuitem" data-kind="{kind}"')
                contrast = ui.button(icon="contrast").props('flat dense aria-label="Light or dark"')
                contrast.on("click", self._contrast, js_handler=_IS_DARK)

    async def _save(self, kind: str) -> None:
        """Give a file to the browser, which takes it home, or say why there is none."""
        name = SAVED[kind][0]
        self.say(f"Making {name} …", "note")
        try:
            content = await self.studio.run(saved, self.desk, kind)
        except CaricliError as error:
            self.say(str(error))
            return
        ui.download.content(content, name)
        self.say(f"Saved: {name}.", "note")

    def _views(self) -> None:
        with ui.element("div").classes("caricli-views").props('role="group" aria-label="Views"'):
            for words, degrees in (("Right", -90), ("Front", 0), ("Left", 90)):
                ui.button(words, on_click=lambda _, turn=degrees: self.head.run_method("view", turn)).props(
                    "flat dense no-caps"
                )
            ui.switch("Turntable", on_change=lambda event: self.head.run_method("turntable", event.value))
            self.texture = ui.switch("Texture", value=True, on_change=self._textured)

    async def do(
        self, operation: Operation, answered: int = 0, words: str = "", picture: np.ndarray | None = None
    ) -> bool:
        """Do an operation for good, show what it made, and keep it in the browser.

        answered: strokes that it was. words: what is said of it, where it has no remark of its own. picture: (H, W, 3)
        that it is for, or None for any.
        Returns whether it was done; where it was refused the page has said why.
        """
        async with self.turn:
            return await self.do_now(operation, answered, words, picture)

    async def do_now(
        self, operation: Operation, answered: int = 0, words: str = "", picture: np.ndarray | None = None
    ) -> bool:
        """As ``do``, for whoever has the turn."""
        self._wanted = None
        try:
            _, done = await self._acted(partial(self.desk.do, operation, picture))
        except CaricliError as error:
            self.say(str(error))
            self._after(len(self.desk.history.done), [], answered)
            return False
        self._after(len(done), [operation], answered)
        remark = self.desk.work.remark
        self.say(f"{_plain(operation.name)}: {remark}." if remark else words, "note")
        return True

    async def _acted(self, act: Callable[[], None]) -> tuple[list[Operation], list[Operation]]:
        """Act; returns what was done before it and after it. Something else may have been done when the page hears."""

        def apart() -> tuple[list[Operation], list[Operation]]:
            before = list(self.desk.history.done)
            act()
            return before, list(self.desk.history.done)

        return await self.studio.run(apart)

    def _after(self, count: int, more: list[Operation], answered: int = 0) -> None:
        """Show the present, and let the browser keep what was done last. count: of operations with it."""
        start = self.desk.start
        kept = None if start is None else asdict(start)
        entries = [operation_to_json(each) for each in more]
        self.keep.run_method("keep", kept, count, entries, answered)
        self.refresh(answered)

    def attempt(self, operation: Operation) -> None:
        """Show what an operation would do, soon; of several that come faster than they are done, the last."""
        self._wanted = operation
        if not self._busy:
            ui.timer(0, self._attempts, once=True)

    async def forget(self) -> None:
        """Show the present again, in place of what is tried."""
        self._wanted = None
        await self.studio.run(self.desk.forget)
        self._frame()

    async def _attempts(self) -> None:
        if self._busy:
            return
        self._busy = True
        try:
            while self._wanted is not None:
                operation = self._wanted
                self._wanted = None
                try:
                    await self.studio.run(self.desk.attempt, operation)
                    self._frame()
                except CaricliError as error:
                    self.say(str(error))
        finally:
            self._busy = False

    async def undo(self) -> None:
        """One operation back."""
        async with self.turn:
            await self.travel(UNDO)

    async def redo(self) -> None:
        """One forth."""
        async with self.turn:
            await self.travel(REDO)

    async def travel(self, way: str) -> None:
        """Undo or redo, for whoever has the turn. way: UNDO or REDO."""
        try:
            before, done = await self._acted(self.desk.undo if way == UNDO else self.desk.redo)
        except CaricliError as error:
            self.say(str(error))
            return
        if len(done) == len(before):
            self.say(f"There is nothing to {way}.", "note")
        else:
            operation = max(before, done, key=len)[-1]
            self.say(f"{way.capitalize()}ne: {_plain(operation.name).lower()}.", "note")
        self._after(len(done), done[len(before) :])

    def refresh(self, answered: int = 0) -> None:
        """Show the present work in every part of the page."""
        history = self.desk.history
        self.undo_button.set_enabled(bool(history.done))
        self.redo_button.set_enabled(bool(history.undone))
        self._frame()
        self._refresh_mode(answered)

    def _frame(self) -> None:
        """Let the head fetch what is shown."""
        self._number += 1
        face = self.desk.work.face
        # Faces of one model share the triangles; a painted one has pictures, hair, and maybe UVs of its own.
        uvs = None if face.mesh.uvs is None else face.mesh.uvs.tobytes()
        layout = (face.mesh.topology_id, uvs, bool(face.pictures), face.hair is None)
        if layout != self._layout:
            self._layout = layout
            ui.run_javascript(
                f"const head = getElement({self.head.id}); head.layout({self._number}).then(() => "
                f"head.show({self._number}))"
            )
            self._textured()
        else:
            self.head.run_method("show", self._number)

    def _textured(self) -> None:
        pictures = self.desk.work.face.pictures
        self.texture.set_visibility(bool(pictures))
        worn = {"skin": pictures.skin, "hair": pictures.hair}
        for name, picture in worn.items():
            shown_at_all = self.texture.value and picture is not None
            self.head.run_method("texture", name, f"{self.base}/{name}/{self._number}" if shown_at_all else None)

    def say(self, words: str, kind: str = "warning") -> None:
        """Tell in words, where a screen reader hears it, too."""
        self.told.text = shown(words, 400)
        self.told.classes(replace=f"caricli-told caricli-{kind}")

    def _show_all(self) -> None:
        self._layout = None
        self.refresh()
        self.studio.warm()

    async def _new(self) -> None:
        await self.studio.run(self.desk.open, None)
        self.say("An empty canvas.", "note")
        self.begun()

    def begun(self) -> None:
        """Show what was opened."""
        self._layout = None
        for mode in self.modes:
            mode.begin()
        done = list(self.desk.history.done)
        self._after(len(done), done)

    async def open(self, path: Path) -> None:
        """Open a file that was sent: a face, a picture, a sketch, a session, or landmarks of the picture that is
        there. Raises CaricliError."""
        # Said here: events of a page that has just been loaded may come in another order than they went.
        self.say(f"Opening {path.name} …", "note")
        self._bare = ""
        if path.suffix.lower() == ".json" and _is_session(path):
            session = read_session(path)
            if session.start not in (None, self.desk.start):
                self.desk.away = session
                raise InputError(f"Open {session.start.file} again, and what was done with it comes back")
            await self.studio.run(self.desk.open_session, session)
        elif self.desk.work.picture is not None and _is_marks(path):
            given = {"landmarks": landmarks_to_json(read_landmarks(path))}
            await self.studio.run(self.desk.do, Operation("marks", given))
        else:
            await self.studio.run(self.desk.open, path)
            self._bare = path.name if await self.studio.run(lacks_materials, path) else ""

    def _was_opened(self, event: Any) -> None:
        refused = event.args.get("refused")
        if refused:
            self.say(refused)
        else:
            self.say(self._opened_words(), "note")
            self.begun()

    def _opened_words(self) -> str:
        if self._bare:
            return f"Opened without its materials: caricli studio {self._bare} opens it in them."
        pictured = self.desk.work.picture is not None and not self.desk.history.done
        return "Opened: draw over it, or place its landmarks." if pictured else "Opened."

    def _returned(self, event: Any) -> None:
        """Show what this tab had before the server ended or the page was loaded again."""
        self.heard.set()
        refused = event.args.get("refused")
        if refused:
            self.say(refused)
        else:
            self.say("Your drawing is back. New begins an empty one.", "note")
            self.begun()

    def _contrast(self, event: Any) -> None:
        """The opposite of what is seen, which the system may have chosen."""
        self.dark.value = not event.args


def studio_page(studio: Studio) -> Callable:
    """What builds the page of a tab."""

    def page(client: Client) -> None:
        desk = studio.new_desk(lambda: client.has_socket_connection)
        shown_page = Page(studio, desk)
        shown_page.build()
        studio.opened[desk.key] = shown_page.open
        client.on_delete(lambda: studio.leave(desk))

    return page


def _button(words: str, icon: str, click: Callable, hint: str) -> ui.button:
    button = ui.button(words, icon=icon, on_click=click).props(f'flat dense no-caps title="{words}: {hint}"')
    return button.classes(f"caricli-{words.lower()}")


def _plain(name: str) -> str:
    """The name of an operation in words."""
    return name.capitalize().replace("_", " ")


def _is_session(path: Path) -> bool:
    return b"caricli.session/" in _start(path)


def _is_marks(path: Path) -> bool:
    return path.suffix.lower() in (".pts", ".txt", ".npy") or b"caricli.landmarks/" in _start(path)


def _start(path: Path) -> bytes:
    """What tells a file from others."""
    return read_start(path, 4096, "a file")
