"""Drawing a face from nothing, or over a picture (sketch paper, section 3.1)."""

from typing import Any

from nicegui import ui

from caricli.structures import Operation
from caricli.studio.components import Canvas
from caricli.studio.modes.mode import Mode

_RADIUS = 10
"""Pixels of a canvas of 512, half the width of the eraser."""


class DrawMode(Mode):
    """A canvas, a pen and an eraser; after every stroke the network's face stands beside it."""

    name = "draw"
    label = "Draw"

    def build(self) -> None:
        """Lay out the tools and the canvas."""
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="Drawing"'):
            tools = ui.toggle({"draw": "Pen", "erase": "Eraser"}, value="draw", on_change=self._use)
            tools.props('no-caps dense unelevated toggle-color=marked toggle-text-color=onmarked aria-label="Tool"')
            clear = ui.button("Clear", on_click=lambda: self.page.do(Operation("clear")))
            clear.props('flat dense no-caps title="Take all lines away"')
            follow = ui.button("Follow my lines", icon="gesture", on_click=self._follow)
            follow.props('flat dense no-caps title="Move the face exactly onto the lines"')
        work = self.page.desk.work
        label = "Canvas. Draw a face with a pen, a finger or a mouse."
        self.canvas = Canvas(work.sketch.size, label, ("draw", "erase"))
        self.canvas.on("operation", self._drawn).on("ready", self.begin)
        ui.label("Draw the outline of a head, then eyes, nose and mouth, in any order.").classes("caricli-hint")

    async def _drawn(self, event: Any) -> None:
        await self.page.do(Operation(event.args["name"], event.args["parameters"]), answered=1)

    async def _follow(self) -> None:
        if not self.page.desk.work.sketch.strokes:
            self.page.say("Draw something first.")
            return
        self.page.say("Following the lines …", "note")
        await self.page.do(Operation("follow"))

    def _use(self, event: Any) -> None:
        self.canvas.run_method("use", event.value, _RADIUS)

    def begin(self) -> None:
        """The canvas of what was opened."""
        work = self.page.desk.work
        underlay = None if work.picture is None else f"{self.page.base}/underlay/{id(work.picture)}"
        self.canvas.resize(work.sketch.size, underlay)
        self.refresh()

    def refresh(self, answered: int = 0) -> None:
        """The lines of the work."""
        lines = [
            {
                "points": stroke.points.tolist(),
                "pressure": None if stroke.pressure is None else stroke.pressure.tolist(),
            }
            for stroke in self.page.desk.work.sketch.strokes
        ]
        self.canvas.run_method("show", lines, answered)
