"""A picture with landmarks that are dragged."""

from typing import Any

from nicegui.element import Element


class LandmarkCanvas(Element, component="landmark_canvas.js"):
    """Emits ``try`` while a hand moves, ``do`` when it lets go, ``forget``, ``chosen``, ``switch`` and ``ready``.

    ``open(scene)`` and ``show(state)`` take what ``Marking`` makes; see ``landmark_canvas.js``.
    """

    def ask(self, name: str, *values: Any) -> None:
        """Call what the canvas offers by a name of ``landmark_canvas.js``."""
        self.run_method("ask", name, *values)
