"""Drawing the lines of a face anew (sketch paper, section 3.2)."""

from typing import Any

from nicegui import ui

from caricli.methods.session.redraw_operations import shown_lines
from caricli.methods.session.work import CANVAS_SIDE
from caricli.structures import Operation
from caricli.studio.components import Canvas
from caricli.studio.modes.mode import Mode

_RADIUS = 8
"""Pixels of the canvas, half the width of the eraser."""


class RedrawMode(Mode):
    """The face's own lines; what is erased is drawn anew, and the face follows."""

    name = "redraw"
    label = "Redraw"

    def build(self) -> None:
        """Lay out the tools and the canvas."""
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="Redrawing"'):
            self.tools = ui.toggle({"erase": "Eraser", "draw": "Pen"}, value="erase", on_change=self._use)
            self.tools.props("no-caps dense unelevated toggle-color=marked toggle-text-color=onmarked")
            self.tools.props('aria-label="Tool"')
        label = "The lines of the face. Erase a piece of one, and draw it anew."
        self.canvas = Canvas((CANVAS_SIDE, CANVAS_SIDE), label, ("mend", "cut"))
        self.canvas.on("operation", self._drawn).on("ready", self._ready)
        hint = "Erase a piece of a line, then draw it anew: the face follows. Strokes elsewhere are wrinkles."
        ui.label(hint).classes("caricli-hint")

    async def _drawn(self, event: Any) -> None:
        before = self.page.desk.history.work
        await self.page.do(Operation(event.args["name"], event.args["parameters"]), answered=1)
        work = self.page.desk.history.work
        if (work.gap is None) != (before.gap is None):
            # Whoever erased will draw, and the other way round.
            self.tools.value = "erase" if work.gap is None else "draw"

    def _use(self, event: Any) -> None:
        self.canvas.run_method("use", event.value, _RADIUS)

    def _ready(self) -> None:
        self.canvas.run_method("use", self.tools.value, _RADIUS)
        self.refresh()

    def refresh(self, answered: int = 0) -> None:
        """The lines of the face."""
        desk = self.page.desk
        strokes = shown_lines(desk.work, desk.tools)
        lines = [{"points": stroke.points.round(2).tolist(), "pressure": None} for stroke in strokes]
        self.canvas.run_method("show", lines, answered)
