"""Placing the landmarks of a picture, or of all pictures of a folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import ui

from caricli.errors import CaricliError, InputError, shown
from caricli.io.landmarks import landmarks_to_json
from caricli.methods.marks.lay_mean_shape import lay_mean_shape, middle_frame
from caricli.methods.session.mark_operations import placed_marks
from caricli.store.face_pictures import FaceReader
from caricli.store.marked_folder import MarkedFolder, seen_marks
from caricli.structures import Landmarks, Operation
from caricli.studio.components import LandmarkCanvas
from caricli.studio.marking import Marking
from caricli.studio.modes.mode import Mode

_STEPS = (("left", "west", [-1, 0]), ("up", "north", [0, -1]), ("down", "south", [0, 1]), ("right", "east", [1, 0]))
"""Words, icons and pixels of the buttons that move a point."""

_TURNS = (
    ("Turn left", "rotate_left", {"turn": -2}),
    ("Turn right", "rotate_right", {"turn": 2}),
    ("Larger", "open_in_full", {"scale": 1.03}),
    ("Smaller", "close_fullscreen", {"scale": 1 / 1.03}),
)
"""Words, icons and changes of the buttons that turn and scale points together."""

_NONE_CHOSEN = "No point is chosen."

_HELP = (
    "Drag a point; or Tab from point to point, arrows to move (Shift: ten pixels), Delete off, Enter on. The wheel "
    "comes nearer, a drag beside the points moves the picture."
)


class LandmarksMode(Mode):
    """A picture, its points, a loupe; a folder picture by picture."""

    name = "landmarks"
    label = "Landmarks"

    def build(self) -> None:
        """Lay out the tools and the canvas."""
        self.marking: Marking | None = None
        self.reader = FaceReader()
        self.picture: Path | None = self.page.studio.picture if self.page.studio.marked else None
        self.fresh = self.picture is not None
        self.passed = ""  # what is said of pictures before this one that could not be read
        self.begun = self.page.desk.start
        self.seen = False
        self.laid = False
        self.mounted = False
        self._place_tools()
        self._move_tools()
        self.canvas = LandmarkCanvas()
        self.canvas.on("try", self._try).on("do", self._do).on("forget", self._forget)
        self.canvas.on("chosen", self._choose).on("switch", self._toggle).on("ready", self._take_canvas)
        ui.label(_HELP).classes("caricli-hint")
        self._end_tools()
        self.page.tabs.on_value_change(self._entered)

    def _place_tools(self) -> None:
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="Landmarks"'):
            find = ui.button("Find the face", icon="face", on_click=self._find).props("flat dense no-caps")
            find.props('title="Let the detector place the landmarks"')
            mean = ui.button("Mean shape", on_click=self._lay).props("flat dense no-caps")
            mean.props('title="Lay the mean face into the middle of the picture"')
            moves = ui.toggle({False: "Points", True: "Groups"}, value=False, on_change=self._grouped)
            moves.props('no-caps dense unelevated toggle-text-color=caricli aria-label="What moves"')
            self.moves = moves
            self.both = ui.switch("Both sides", value=True, on_change=self._symmetric)
            self.lines = ui.switch("Face", value=True, on_change=self._overlaid).props(
                'title="Lines of the face that fits"'
            )

    def _move_tools(self) -> None:
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="The chosen point"'):
            self.chosen = ui.label(_NONE_CHOSEN).classes("caricli-chosen")
            with ui.element("div").classes("caricli-icons"):
                self._icons()

    def _icons(self) -> None:
        for words, icon, step in _STEPS:
            self._tool(f"Move {words}", icon, "nudge", step)
        self._tool("Switch the point off or on", "visibility_off", "toggle")
        for words, icon, change in _TURNS:
            self._tool(f"{words}: the group, or the whole face", icon, "turn", change)
        self._tool("Nearer", "zoom_in", "magnify", 1.5)
        self._tool("Farther", "zoom_out", "magnify", 1 / 1.5)
        self._tool("The whole picture", "fit_screen", "fit")

    def _tool(self, words: str, icon: str, name: str, *values: Any) -> None:
        button = ui.button(icon=icon, on_click=lambda: self.canvas.ask(name, *values))
        button.props(f'flat dense aria-label="{words}" title="{words}"')

    def _end_tools(self) -> None:
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="Results"'):
            if self.page.studio.marked is not None:
                self._folder_tools(len(self.page.studio.marked.pictures) > 1)
            face = ui.button("Make the face", icon="view_in_ar", on_click=self._make).props("outline dense no-caps")
            face.props('title="Reconstruct the face that the landmarks are of"')
        self._tell_progress()

    def _folder_tools(self, many: bool) -> None:
        if many:
            before = ui.button(icon="chevron_left", on_click=lambda: self._go(-1))
            before.props('flat dense aria-label="The picture before"')
        self.told = ui.label("").classes("caricli-progress")
        if many:
            after = ui.button(icon="chevron_right", on_click=lambda: self._go(1))
            after.props('flat dense aria-label="The next picture"')
        save = ui.button("Done", icon="done", on_click=self._save).props("flat dense no-caps")
        save.props('title="Write the landmarks beside the picture"')
        if many:
            following = ui.button("Done, next", icon="skip_next", on_click=self._next)
            following.props("outline dense no-caps")

    def begin(self) -> None:
        """The picture of what was opened; one of the folder only where it is the one that was asked for."""
        desk = self.page.desk
        if desk.start != self.begun:
            self.begun = desk.start
            self.picture = None
            self.passed = ""
        self.seen = False
        self.chosen.text = _NONE_CHOSEN
        self.laid = False
        self._tell_progress()
        if self.shown:
            ui.timer(0, self._enter, once=True)

    def _take_canvas(self) -> None:
        """The browser has the canvas, which it makes when the mode is first shown."""
        self.mounted = True
        self.begin()

    async def refresh_now(self) -> None:
        """Show the landmarks of the work and the face that follows them."""
        landmarks = self.page.desk.work.landmarks
        if not self.laid or not self.shown:
            return
        if landmarks is None:
            self.canvas.run_method(
                "show", {"points": [None] * self._count(), "guess": [], "curves": [], "mirror": None}
            )
        else:
            self.canvas.run_method("show", await self.page.studio.run(self._marking().state, landmarks))

    def refresh(self, answered: int = 0) -> None:
        """Show the present work."""
        ui.timer(0, self.refresh_now, once=True)

    def _marking(self) -> Marking:
        if self.marking is None:
            self.marking = Marking(self.page.studio.tools.encoder.fitter)
        return self.marking

    def _count(self) -> int:
        return len(self._marking().model.template.annotation.landmarks)

    async def _entered(self) -> None:
        if self.shown:
            await self._enter()

    async def _enter(self) -> None:
        """Landmarks to begin with, once for every picture: those beside it, or those that are found in it."""
        if not self.mounted:
            return
        await self.page.heard.wait()
        desk = self.page.desk
        pixels = desk.work.picture
        if pixels is None:
            self.page.say("Landmarks lie on a picture: open one first.", "note")
            return
        if not self.laid:
            await self._lay_out(pixels)
        if self.seen or desk.work.landmarks is not None:
            await self.refresh_now()
            return
        self.seen = True
        folder = self.page.studio.marked
        if folder is not None and self.fresh:
            self.fresh = False
            first = self._first(folder)
            if first != self.picture:
                # What was the first without landmarks when the server began may have some by now.
                await self._open_first(folder.candidates(first))
                return
        if folder is not None and self.picture is not None and folder.is_done(self.picture):
            try:
                name = folder.file(self.picture).name
                await self._put(pixels, folder.read(self.picture), f"Landmarks of {name}.")
            except CaricliError as error:
                self.page.say(self._after_passed(str(error)))
        else:
            await self._find()

    def _first(self, folder: MarkedFolder) -> Path:
        """The picture to begin with: one that the browser kept work on, where it is not done."""
        start = None if self.page.desk.away is None else self.page.desk.away.start
        left = (each for each in folder.pictures if start is not None and each.name == start.file)
        return next((each for each in left if not folder.is_done(each)), folder.first())

    async def _lay_out(self, pixels: np.ndarray) -> None:
        """Give the canvas its picture; what follows the landmarks is loaded when it is first asked for."""
        marking = await self.page.studio.run(self._marking)
        size = (pixels.shape[1], pixels.shape[0])
        scene = marking.scene(self._count(), size, f"{self.page.base}/underlay/{id(pixels)}")
        self.canvas.run_method("open", scene)
        self.laid = True

    async def _put(self, pixels: np.ndarray, landmarks: Landmarks | None, words: str = "") -> None:
        """Landmarks for a picture, unless another one was opened while they were made."""
        if landmarks is not None:
            operation = Operation("marks", {"landmarks": landmarks_to_json(landmarks)})
            await self.page.do(operation, words=self._after_passed(words), picture=pixels)

    async def _find(self) -> None:
        pixels = self.page.desk.work.picture
        if pixels is None:
            return
        self.page.say("Looking for the face …", "note")
        landmarks = await self.page.studio.run(seen_marks, pixels, self._count(), self.reader)
        words = "Landmarks as the detector marks them."
        if landmarks is None:
            landmarks = self._mean(pixels)
            words = "No face was seen: the mean shape lies on the picture."
        await self._put(pixels, landmarks, words)

    async def _lay(self) -> None:
        pixels = self.page.desk.work.picture
        if pixels is not None:
            await self._put(pixels, self._mean(pixels))

    def _mean(self, pixels: np.ndarray) -> Landmarks | None:
        """The mean shape in the middle of a picture, or None where that has no room for it, which is said."""
        size = (pixels.shape[1], pixels.shape[0])
        try:
            return lay_mean_shape(self._marking().model.template, middle_frame(size), size)
        except CaricliError as error:
            self.page.say(self._after_passed(str(error)))
            return None

    async def _make(self) -> None:
        await self.page.do(Operation("mark_face"), words="The face that the landmarks are of.")

    async def _try(self, event: Any) -> None:
        operation = Operation(event.args["name"], event.args["parameters"])
        try:
            state = await self.page.studio.run(self._tried, operation, int(event.args["seq"]))
        except CaricliError as error:
            self.page.say(str(error))
            state = {"seq": int(event.args["seq"])}
        self.canvas.run_method("show", state)

    def _tried(self, operation: Operation, seq: int) -> dict[str, Any]:
        desk = self.page.desk
        desk.attempt(operation)
        assert desk.work.landmarks is not None
        return self._marking().state(desk.work.landmarks, seq)

    async def _do(self, event: Any) -> None:
        await self.page.do(Operation(event.args["name"], event.args["parameters"]))

    async def _forget(self) -> None:
        await self.page.studio.run(self.page.desk.forget)
        await self.refresh_now()

    def _choose(self, event: Any) -> None:
        self.chosen.text = event.args["label"]

    def _toggle(self, event: Any) -> None:
        switch = self.both if event.args["name"] == "symmetric" else self.moves
        switch.value = not switch.value

    def _symmetric(self, event: Any) -> None:
        self.canvas.run_method("set", "symmetric", event.value)

    def _grouped(self, event: Any) -> None:
        self.canvas.run_method("set", "grouped", event.value)

    def _overlaid(self, event: Any) -> None:
        self.canvas.run_method("set", "overlay", event.value)

    async def _save(self) -> bool:
        """Write the landmarks beside their picture, and say so. Returns whether it could be done."""
        folder = self.page.studio.marked
        picture = self.picture
        begun = self.begun
        desk = self.page.desk
        if folder is None or picture is None:
            self.page.say("There are no landmarks of a picture that caricli was started with; take them home by Save.")
            return False

        def write() -> Path:
            # In the thread, where what a hand did before is done by now.
            if desk.start != begun:
                raise InputError(f"{shown(picture.name)}: nothing is written, for another picture was opened")
            return folder.write(picture, placed_marks(desk.history.work))

        try:
            file = await self.page.studio.run(write)
        except CaricliError as error:
            self.page.say(str(error))
            return False
        self.page.say(f"Written to {shown(file.name)}.", "note")
        self._tell_progress()
        return True

    async def _next(self) -> None:
        folder = self.page.studio.marked
        if folder is None or self.picture is None or not await self._save():
            return
        left = folder.left(self.picture)
        if left:
            await self._open_first(left)
        else:
            self.page.say("All pictures are done.", "note")

    async def _go(self, step: int) -> None:
        folder = self.page.studio.marked
        if folder is not None and folder.pictures:
            await self._open_first(folder.others(self.picture or folder.pictures[0], step))

    async def _open_first(self, pictures: Sequence[Path]) -> None:
        """Open the first of some pictures that can be read, and say which ones before it cannot."""
        self.fresh = False
        self.passed = ""
        for picture in pictures:
            try:
                await self.page.studio.run(self.page.desk.open, picture)
            except CaricliError as error:
                self.passed += f"Passed over {error}. "
                continue
            self._show_opened(picture)
            return
        self.page.say(self.passed)

    def _show_opened(self, picture: Path) -> None:
        self.picture = picture
        self.begun = self.page.desk.start
        if self.page.desk.history.done:
            self.page.say(self._after_passed(f"What was done with {shown(picture.name)} is back."), "note")
        self.page.begun()

    def _after_passed(self, words: str) -> str:
        """Words behind what is said of pictures that were passed over, which is said once."""
        whole = self.passed + words
        self.passed = ""
        return whole

    def _tell_progress(self) -> None:
        folder = self.page.studio.marked
        if folder is None:
            return
        name = "another picture" if self.picture is None else shown(self.picture.name)
        count = len(folder.pictures)
        self.told.text = f"{name} · {folder.done} of {count} done" if count > 1 else name
