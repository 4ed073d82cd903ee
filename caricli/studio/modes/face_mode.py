"""Changing a face by sliders, and by points that are dragged."""

import asyncio
import json
from functools import partial
from typing import Any

from nicegui import ui

from caricli.errors import CaricliError
from caricli.methods.edit.handle_points import vertex_of
from caricli.methods.session.pull_basis import pull_basis
from caricli.structures import Operation
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.landmarks import POINT_NAMES
from caricli.studio.components import Slider
from caricli.studio.modes.mode import Mode

_REACH = 4.0
"""Standard deviations at the ends of a label's slider."""

_AT_HAND = 1000
"""Milliseconds after which a slider is let go: an answer that comes late must not take back a key that came after."""

_TO_A_SIDE = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")
"""Actions that go to a side: with the same of the other side they would go nowhere."""

_PERCENT = 15.0
"""Of the head's height, the farthest that numbers pull a point."""


class FaceMode(Mode):
    """Sliders of labels with locks, of expressions, and handles on the surface."""

    name = "face"
    label = "Face"

    def build(self) -> None:
        """Lay out the groups."""
        self.labels: dict[str, Slider] = {}
        self.locks: dict[str, ui.checkbox] = {}
        self.actions: dict[str, Slider] = {}
        self.sliding = asyncio.Lock()
        with ui.scroll_area().classes("caricli-scroll").props('tabindex="0" aria-label="Face"'):
            with _group("Caricature", True):
                self._caricature()
            with _group("Pull points", True):
                self._pulling()
            with _group("Labels", True):
                for name in self.page.studio.tools.directions.names:
                    self._label(name)
            with _group("Expressions", False):
                self.mirrored = ui.switch("Both sides", value=True)
                ui.button("At rest", on_click=self._rest).props("flat dense no-caps")
                for name in ARKIT_NAMES:
                    self._action(name)

    def listen(self) -> None:
        """Points of the head are dragged."""
        self.page.head.on("grab", self._grab).on("pull", self._pull)

    def refresh(self, answered: int = 0) -> None:
        """Sliders where the work has them, but for one that a hand is at."""
        self._set_sliders(f"performance.now() - (slider.moved ?? -Infinity) > {_AT_HAND}")

    def _set_sliders(self, where: str) -> None:
        """Sliders where the work has them. where: what has to be true of one, in the browser."""
        work = self.page.desk.work
        values = {slider.id: work.strengths.get(name, 0.0) for name, slider in self.labels.items()}
        values |= {slider.id: work.weights.get(name, 0.0) for name, slider in self.actions.items()}
        # Where a hand moved them the server does not know.
        move = f"const slider = getHtmlElement(id); if (slider && {where}) slider.value = value;"
        ui.run_javascript(f"for (const [id, value] of Object.entries({json.dumps(values)})) {{ {move} }}")

    def _caricature(self) -> None:
        with ui.row().classes("caricli-row"):
            for words, strength in (("A little", 0.25), ("More", 0.5), ("Strong", 1.0)):
                operation = Operation("caricaturize", {"strength": strength, "mode": "own"})
                ui.button(words, on_click=lambda _, each=operation: self.page.do(each)).props(
                    f'outline dense no-caps title="Enlarge what sets this face apart by {strength:g}"'
                )
        ui.label("Enlarges what sets this face apart. The label Caricature goes the way of all caricatures.").classes(
            "caricli-hint"
        )

    def _pulling(self) -> None:
        with ui.row().classes("caricli-row"):
            self.pulled = ui.switch("Drag points on the head", on_change=self._allow)
            self.symmetric = ui.switch("Both sides", value=True)
        with ui.row().classes("caricli-row"):
            names = {name: name.replace("_", " ") for name in POINT_NAMES}
            self.point = ui.select(names, value="nose_tip", label="Point").props("dense outlined").classes("w-40")
            self.lengths = [
                ui.number(words, value=0, min=-_PERCENT, max=_PERCENT, step=1).props("dense outlined").classes("w-24")
                for words in ("Left %", "Up %", "Front %")
            ]
            ui.button("Pull", on_click=self._pull_named).props("outline no-caps")

    def _label(self, name: str) -> None:
        with ui.element("div").classes("caricli-slider"):
            ui.label(_words(name))
            slider = Slider(_words(name), (-_REACH, _REACH), 0.05)
            slider.on_value(partial(self._slide, name), partial(self._slid, name))
            self.locks[name] = ui.checkbox().props(
                f'dense checked-icon=lock unchecked-icon=lock_open aria-label="Lock {_words(name)}"'
            )
            self.labels[name] = slider

    def _action(self, name: str) -> None:
        with ui.element("div").classes("caricli-slider"):
            ui.label(_words(name))
            slider = Slider(_words(name), (0, 1), 0.01)
            slider.on_value(partial(self._act, name), partial(self._acted, name))
            self.actions[name] = slider

    def _semantic(self, name: str, value: float) -> Operation | None:
        """The way from the present to a slider's value, or None where it is there."""
        more = float(value) - self.page.desk.history.work.strengths.get(name, 0.0)
        keep = [other for other, lock in self.locks.items() if lock.value and other != name]
        if abs(more) < 1e-6 or self.locks[name].value:
            return None
        return Operation("semantic", {"strengths": {name: more}, "keep": keep})

    async def _slide(self, name: str, value: float) -> None:
        if self.sliding.locked():
            return  # what still comes of a slider that is let go would be added to where it goes
        operation = self._semantic(name, value)
        if operation:
            self.page.attempt(operation)
        else:
            await self.page.forget()

    async def _slid(self, name: str, value: float) -> None:
        # One after the other: the way to a value begins where the one before has ended.
        async with self.sliding:
            operation = self._semantic(name, value)
            if operation:
                await self.page.do(operation)
        if self.locks[name].value:
            self.page.say(f"{_words(name)} is locked.")
            self._set_sliders("true")

    def _expression(self, name: str, value: float) -> Operation:
        names = {name}
        if self.mirrored.value and name not in _TO_A_SIDE:
            names |= {name.replace("Left", "Right"), name.replace("Right", "Left")} & set(ARKIT_NAMES)
        return Operation("expression", {"weights": dict.fromkeys(sorted(names), float(value))})

    def _act(self, name: str, value: float) -> None:
        self.page.attempt(self._expression(name, value))

    async def _acted(self, name: str, value: float) -> None:
        await self.page.do(self._expression(name, value))

    async def _rest(self) -> None:
        weights = self.page.desk.history.work.weights
        if weights:
            await self.page.do(Operation("expression", {"weights": dict.fromkeys(weights, 0.0)}))

    def _allow(self, event: Any) -> None:
        self.page.head.run_method("pulling", event.value)

    async def _grab(self, event: Any) -> None:
        vertex = int(event.args["vertex"])
        desk = self.page.desk
        try:
            desk.basis = await self.page.studio.run(
                pull_basis, desk.history.work, str(vertex), desk.tools, self._both(str(vertex))
            )
        except CaricliError as error:
            self.page.say(str(error))
        else:
            self.page.head.run_method("basis", vertex, vertex)

    async def _pull(self, event: Any) -> None:
        vertex = str(int(event.args["vertex"]))
        lengths = [round(float(each), 6) for each in event.args["by"]]
        if any(lengths):
            await self.page.do(_handle(vertex, lengths, self._both(vertex)))

    async def _pull_named(self) -> None:
        lengths = [f"{each.value or 0:g}%" for each in self.lengths]
        await self.page.do(_handle(self.point.value, lengths, self._both(self.point.value)))

    def _both(self, where: str) -> bool:
        """Whether the other side does the same; points of the middle, vertices or names, have no other side."""
        template = self.page.studio.tools.model.template
        mirror = template.annotation.mirror
        vertex = vertex_of(where, template)
        return bool(self.symmetric.value and mirror is not None and mirror[vertex] != vertex)


def _handle(where: str, lengths: list, symmetric: bool) -> Operation:
    return Operation("handle", {"handles": {where: lengths}, "symmetric": symmetric})


def _group(words: str, opened: bool) -> ui.expansion:
    return ui.expansion(words, value=opened).classes("caricli-group").props("dense expand-separator")


def _words(name: str) -> str:
    """The name of a label or an action, as people write it: BigNose, "Big nose"."""
    spaced = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name)
    return spaced.strip().capitalize()
