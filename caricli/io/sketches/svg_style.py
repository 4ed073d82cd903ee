"""What of an SVG's style says whether and how a line is drawn."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(px|pt|pc|mm|cm|in|)\s*")
_UNITS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0}
_SELECTOR = re.compile(r"([.#][\w-]+|(?:^|(?<=[\s>+~]))(?:[\w-]+|\*))$")
_COMMENT = re.compile(r"/\*.*?(?:\*/|\Z)", re.DOTALL)
_KEYS = (
    *("stroke", "stroke-width", "stroke-opacity", "fill", "fill-rule", "fill-opacity", "opacity"),
    *("display", "visibility", "transform", "transform-origin", "transform-box", "clip-path", "clip-rule"),
)
_OWN_BOXES = {"fill-box", "stroke-box", "content-box", "border-box"}
_LARGEST = 1e9
_FAINT = 0.2
"""Luma, 0 to 1, by which a fill that is ink differs from the paper, at least."""
_SAME = 0.1
"""Of the range of red, green or blue: a stroke that differs less from the paper in each cannot be seen."""

Paper = tuple[float, float, float] | None
"""Red, green and blue, 0 to 1, of what is drawn on; None where it is no single colour."""
WHITE: Paper = (1.0, 1.0, 1.0)

Rules = Mapping[str, Mapping[str, tuple[int, str]]]
"""By selector and name: how many rules stand before it in the sheet, and a value."""


def length_in_pixels(text: str | None) -> float | None:
    """A length such as ``12``, ``3.5mm`` or ``1in``, 96 pixels an inch; None where it is none, or a percentage."""
    match = _NUMBER.fullmatch(text[:64]) if text else None
    if match is None:
        return None
    value = float(match[1]) * _UNITS[match[2]]
    return value if abs(value) <= _LARGEST else None


def style_rules(text: str) -> Rules:
    """Declarations of a style sheet by ``.class``, ``#id``, the name of an element or ``*``: each what a selector ends
    with. Other selectors are passed over."""
    rules: dict[str, dict[str, tuple[int, str]]] = {}
    for place, rule in enumerate(_COMMENT.sub("", text).split("}")[:-1]):
        before, _, body = rule.rpartition("{")
        declarations = {key: (place, value) for key, value in _declarations(body).items()}
        for selector in before.rpartition("{")[2].split(","):
            match = _SELECTOR.search(selector.strip())
            if match:
                rules.setdefault(match[1], {}).update(declarations)
    return rules


def _told(selectors: list[str], rules: Rules) -> dict[str, str]:
    """What selectors of equal weight say together: where they say the same, the last one of the sheet counts."""
    pairs = [pair for selector in selectors for pair in rules.get(selector, {}).items()]
    return {key: value for key, (_, value) in sorted(pairs, key=lambda pair: pair[1][0])}


def _declarations(text: str) -> dict[str, str]:
    """Values by their names; by names with a mark of exclamation those that are important."""
    declarations: dict[str, str] = {}
    for entry in text.split(";"):
        key, _, told = entry.partition(":")
        value, important, _ = told.partition("!")
        if key.strip() in _KEYS:
            declarations[key.strip() + important] = value.strip()
    return declarations


@dataclass(frozen=True)
class Style:
    """How a line is drawn.

    stroke, fill: what it is drawn and filled with, as CSS has it. width: of the stroke, in units of the drawing, or
    None. clear: whether a stroke, and what fills, cannot be seen. hidden: nor anything in it. visible: what is in it
    may be where it is not. even_odd: by which rule it is filled. clip_even_odd: and by which it clips. transform,
    origin, clip: of this element alone, as CSS has them, or None; the origin is the box where that is the element's.
    """

    stroke: str = "none"
    width: float | None = None
    fill: str = "black"
    clear: tuple[bool, bool] = (False, False)
    hidden: bool = False
    visible: bool = True
    even_odd: bool = False
    clip_even_odd: bool = False
    transform: str | None = None
    origin: str | None = None
    clip: str | None = None

    def stroked(self, paper: Paper = WHITE) -> bool:
        """Whether there is a stroke to be seen on a paper."""
        if self.width == 0 or self.clear[0] or _is_clear(self.stroke):
            return False
        colour = _colour(self.stroke)
        if colour is None or paper is None:
            return True
        return max(abs(own - other) for own, other in zip(colour, paper, strict=True)) >= _SAME

    def inked(self, paper: Paper = WHITE) -> bool:
        """Whether it is filled with what stands out from a paper; gradients and patterns do."""
        if self.clear[1] or _is_clear(self.fill):
            return False
        colour = _colour(self.fill)
        return colour is None or paper is None or abs(_luma(colour) - _luma(paper)) > _FAINT

    def unseen(self, paper: Paper = WHITE) -> bool:
        """Whether there is a stroke, but neither it nor what fills can be seen on a paper."""
        return not (_is_clear(self.stroke) or self.stroked(paper) or self.inked(paper))

    def covered(self, paper: Paper) -> Paper:
        """The paper where something so filled lies over a paper."""
        return paper if self.clear[1] or _is_clear(self.fill) else _colour(self.fill)

    def within(self, element: Element, rules: Rules) -> "Style":
        """The style of an element in one of this style. rules: as ``style_rules`` gives them."""
        values = {key: value for key in _KEYS if (value := element.get(key)) is not None}
        classes = [f".{word}" for word in (element.get("class") or "").split()]
        for selectors in (["*"], [str(element.tag).rpartition("}")[2]], classes, [f"#{element.get('id')}"]):
            values |= _told(selectors, rules)
        values |= _declarations(_COMMENT.sub("", element.get("style") or ""))
        values |= {key: values[f"{key}!"] for key in _KEYS if f"{key}!" in values}
        told = {key: value for key, value in values.items() if value != "inherit"}
        width = length_in_pixels(told.get("stroke-width"))
        clear = [_is_nothing(told, f"{what}-opacity", self.clear[k]) for k, what in enumerate(("stroke", "fill"))]
        return Style(
            stroke=told.get("stroke", self.stroke),
            width=self.width if width is None else width,
            fill=told.get("fill", self.fill),
            clear=(clear[0], clear[1]),
            hidden=self.hidden or told.get("display") == "none" or _is_nothing(told, "opacity", False),
            visible=told["visibility"] == "visible" if "visibility" in told else self.visible,
            even_odd=told["fill-rule"] == "evenodd" if "fill-rule" in told else self.even_odd,
            clip_even_odd=told["clip-rule"] == "evenodd" if "clip-rule" in told else self.clip_even_odd,
            transform=told.get("transform"),
            origin=box if (box := told.get("transform-box")) in _OWN_BOXES else told.get("transform-origin"),
            clip=told.get("clip-path"),
        )


def _is_nothing(values: Mapping[str, str], key: str, inherited: bool) -> bool:
    """Whether an opacity is none at all."""
    number = length_in_pixels((values.get(key) or "").strip().removesuffix("%"))
    return inherited if number is None else number <= 0


def _is_clear(paint: str) -> bool:
    """Whether nothing of a stroke or a fill can be seen."""
    from svgelements import Color

    if paint in ("none", "transparent"):
        return True
    try:
        return bool(Color(paint[:64]).opacity == 0)
    except (AttributeError, ValueError, TypeError, IndexError):
        return False


def _colour(paint: str) -> Paper:
    """A colour, or None for what is none, such as a gradient or a pattern."""
    from svgelements import Color

    if paint.startswith("url("):
        return None
    try:
        colour = Color(paint[:64])
        return colour.red / 255, colour.green / 255, colour.blue / 255
    except (AttributeError, ValueError, TypeError, IndexError):
        return None


def _luma(colour: tuple[float, float, float]) -> float:
    red, green, blue = colour
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
