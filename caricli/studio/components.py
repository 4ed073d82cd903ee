"""The parts of the page that are drawn in the browser."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import nicegui
from nicegui.element import Element

from caricli.structures import Start

_THREE = Path(nicegui.__file__).parent / "elements" / "scene" / "dist"
"""three.js as it comes with NiceGUI."""


class Canvas(Element, component="canvas.js"):
    """Where lines are drawn; emits ``operation`` with the name and the parameters of one.

    ``show(lines, answered)`` gives it the lines of the work.
    """

    def __init__(self, size: tuple[int, int], label: str, names: tuple[str, str]) -> None:
        """size: (width, height) pixels. label: what a screen reader says. names: of what pen and eraser do."""
        super().__init__()
        self.resize(size)
        self._props["drawn"] = names[0]
        self._props["rubbed"] = names[1]
        self._props["label"] = label

    def resize(self, size: tuple[int, int], underlay: str | None = None) -> None:
        """Another canvas. underlay: address of the picture below it."""
        width, height = size
        self._props["width"] = width
        self._props["height"] = height
        self._props["underlay"] = underlay
        self.update()


class LandmarkCanvas(Element, component="landmark_canvas.js"):
    """A picture with landmarks that are dragged.

    It emits ``try`` while a hand moves, ``do`` when it lets go, ``forget``, ``chosen``, ``switch`` and ``ready``.
    ``open(scene)`` and ``show(state)`` take what ``Marking`` makes; see ``landmark_canvas.js``.
    """

    def ask(self, name: str, *values: Any) -> None:
        """Call what the canvas offers by a name of ``landmark_canvas.js``."""
        self.run_method("ask", name, *values)


class Head(Element, component="head.js", esm={"nicegui-scene": str(_THREE)}):
    """The head in three dimensions; emits ``grab`` and ``pull`` where points are dragged, and
    ``stroke`` where a line is drawn on it."""

    def __init__(self, base: str) -> None:
        """base: address of what it shows."""
        super().__init__()
        self._props["base"] = base
        self._props["label"] = "The head in three dimensions. Arrow keys turn it, the wheel comes nearer."


class Slider(Element):
    """A slider of the browser's own, which keys and screen readers know."""

    def __init__(self, label: str, reach: tuple[float, float], step: float) -> None:
        """label: what a screen reader says. reach: least and largest value. step: between values."""
        super().__init__("input")
        # No value here: the browser would go back to it whenever anything else of the page changes.
        self._props |= {"type": "range", "min": reach[0], "max": reach[1], "step": step}
        self._props["aria-label"] = label

    def on_value(self, moving: Callable[[float], object], moved: Callable[[float], object]) -> None:
        """moving: called with the value while a hand moves it. moved: when the hand lets go."""
        emit = "event => { event.target.moved = performance.now(); emit(Number(event.target.value)); }"
        self.on("input", lambda event: moving(float(event.args)), throttle=0.03, js_handler=emit)
        self.on("change", lambda event: moved(float(event.args)), js_handler=emit)


class Keep(Element, component="keep.js"):
    """Keeps the session in the browser, opens files, listens to keys: ``returned`` or ``nothing``, ``opened``,
    ``undo``, ``redo``."""

    def __init__(self, base: str, start: Start | None) -> None:
        """base: address that files are sent to. start: Start of the session, or None."""
        super().__init__()
        self._props["base"] = base
        self._props["begun"] = None if start is None else asdict(start)
