"""Changing a face by gestures on the head, from any side (sketch paper, section 3.3)."""

from functools import partial
from typing import Any

from nicegui import ui

from caricli.errors import CaricliError
from caricli.methods.session.gesture_operations import meaning_of
from caricli.structures import Operation
from caricli.structures.gesture import LEVELS
from caricli.studio.modes.mode import Mode

TOOLS = {
    "turn": "Turn",
    "gesture": "Gesture",
    "brush": "Brush",
    "rub": "Rub out",
    "region": "Region",
    "line": "Line",
}
"""What a stroke on the head is."""

KEYS = {"t": "turn", "g": "gesture", "b": "brush", "x": "rub", "r": "region", "l": "line"}

_RADIUS = 12
"""Pixels of the screen, of the brush."""

_HINT = (
    "Draw on the head; with Turn the pointer turns it. A closed line chooses a region; a line moves what is brushed, "
    "or the outline; one, two or three loops above a line bulge, below it they press in; an arrow to the left undoes, "
    "to the right redoes."
)


class RefineMode(Mode):
    """Strokes on the head, which a network takes for gestures, and a button and a key for each."""

    name = "refine"
    label = "Refine"

    def build(self) -> None:
        """Lay out the tools."""
        with ui.element("div").classes("caricli-tools").props('role="group" aria-label="Strokes on the head"'):
            self.tool = ui.toggle(TOOLS, value="gesture", on_change=self._use)
            self.tool.props(
                "no-caps dense unelevated toggle-color=marked toggle-text-color=onmarked "
                'aria-label="What strokes on the head are"'
            )
            self.symmetric = ui.switch("Both sides", value=True)
        for words, name in (("Bulge", "bulge"), ("Press in", "depress")):
            with ui.element("div").classes("caricli-row").props(f'role="group" aria-label="{words}"'):
                ui.label(words).classes("w-20")
                for level in range(1, LEVELS + 1):
                    key = f"{'Shift+' if name == 'depress' else ''}{level}"
                    button = ui.button(str(level), on_click=partial(self._raise, name, level))
                    button.props(f'outline dense aria-label="{words} {level}" title="{words} {level}: {key}"')
                    button.style("min-width: 40px")
        with ui.element("div").classes("caricli-row"):
            free = ui.button("Deselect", on_click=self._deselect)
            free.props('flat dense no-caps title="Neither handles nor a region: D"')
            self.chosen = ui.label("")
        ui.label(_HINT).classes("caricli-hint")
        keys = ", ".join(f"{key.upper()} {TOOLS[tool].lower()}" for key, tool in KEYS.items())
        self.keys = ui.switch(f"Keys: {keys}", value=True).classes("caricli-hint")
        ui.keyboard(on_key=self._key, repeating=False)

    def listen(self) -> None:
        """Strokes on the head; elsewhere it only turns."""
        self.page.head.on("stroke", self._drawn)
        self.page.tabs.on_value_change(self._use)

    def refresh(self, answered: int = 0) -> None:
        """What is selected."""
        work = self.page.desk.work
        region = [] if work.region is None else work.region.tolist()
        self.page.head.run_method("select", work.handles.tolist(), region)
        parts = [f"{len(work.handles)} handles"] if len(work.handles) else []
        self.chosen.text = ", ".join([*parts, "a region" if region else "all may move"])

    def _use(self) -> None:
        tool = self.tool.value if self.shown else "turn"
        self.page.head.run_method("drawing", None if tool == "turn" else tool, _RADIUS)

    async def _drawn(self, event: Any) -> None:
        stroke = {"points": event.args["points"], "camera": event.args["camera"]}
        tool = event.args["tool"]
        if tool in ("brush", "rub"):
            await self._do("brush", stroke | {"radius": _RADIUS, "erase": tool == "rub"})
        elif tool == "region":
            await self._do("region", stroke)
        elif tool == "line":
            await self._do("line", stroke | {"symmetric": self.symmetric.value})
        else:
            await self._gesture(Operation("gesture", stroke | {"symmetric": self.symmetric.value}))

    async def _gesture(self, operation: Operation) -> None:
        """Do what a stroke means, before what comes after it, and say what that is; where it is doubtful, say so and do
        nothing."""
        async with self.page.turn:
            try:
                meant = await self.page.studio.run(meaning_of, operation, self.page.studio.tools)
            except CaricliError as error:
                self.page.say(f"{error}. Nothing was done: draw it again, or press its button.")
                return
            if isinstance(meant, Operation):
                await self.page.do_now(meant, words=_words(meant))
            else:
                await self.page.travel(meant)

    async def _raise(self, name: str, level: int) -> None:
        await self._do(name, {"level": level, "symmetric": self.symmetric.value})

    async def _deselect(self) -> None:
        await self._do("deselect", {})

    async def _do(self, name: str, parameters: dict) -> None:
        """Do an operation, and say which."""
        operation = Operation(name, parameters)
        await self.page.do(operation, words=_words(operation))

    async def _key(self, event: Any) -> None:
        listening = self.shown and self.keys.value and event.action.keydown
        if not listening or event.modifiers.ctrl or event.modifiers.meta:
            return
        digit = str(event.key.code).removeprefix("Digit")
        letter = str(event.key).lower()
        if digit in {str(level) for level in range(1, LEVELS + 1)}:
            await self._raise("depress" if event.modifiers.shift else "bulge", int(digit))
        elif letter == "d":
            await self._deselect()
        elif letter in KEYS:
            self.tool.value = KEYS[letter]


def _words(operation: Operation) -> str:
    """What an operation is called, and its level."""
    name = {"depress": "press in"}.get(operation.name, operation.name).capitalize()
    level = operation.parameters.get("level")
    return f"{name}." if level is None else f"{name} {level}."
