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
    *("display", "visibility", "transform"),
)
_LARGEST = 1e9
_PAPER = 0.8
"""Luma, 0 to 1, of what is no ink, at least."""

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

    line: with a stroke. width: of it, in units of the drawing, or None. filled: with what is no paper, which is bright.
    clear: whether a stroke, and what fills, cannot be seen. hidden: nor anything in it. visible: what is in it may be
    where it is not. even_odd: by which rule it is filled. transform: of this element alone, or None.
    """

    line: bool = False
    width: float | None = None
    filled: bool = True
    clear: tuple[bool, bool] = (False, False)
    hidden: bool = False
    visible: bool = True
    even_odd: bool = False
    transform: str | None = None

    @property
    def stroked(self) -> bool:
        """Whether there is a stroke to be seen."""
        return self.line and self.width != 0 and not self.clear[0]

    @property
    def inked(self) -> bool:
        """Whether it is filled with what is no paper."""
        return self.filled and not self.clear[1]

    def within(self, element: Element, rules: Rules) -> "Style":
        """The style of an element in one of this style. rules: as ``style_rules`` gives them."""
        values = {key: value for key in _KEYS if (value := element.get(key)) is not None}
        classes = [f".{word}" for word in (element.get("class") or "").split()]
        for selectors in (["*"], [str(element.tag).rpartition("}")[2]], classes, [f"#{element.get('id')}"]):
            values |= _told(selectors, rules)
        values |= _declarations(_COMMENT.sub("", element.get("style") or ""))
        values |= {key: values[f"{key}!"] for key in _KEYS if f"{key}!" in values}
        stroke = values.get("stroke", "inherit")
        width = length_in_pixels(values.get("stroke-width"))
        fill = values.get("fill", "inherit")
        rule = values.get("fill-rule", "inherit")
        seen = values.get("visibility", "inherit")
        return Style(
            self.line if stroke == "inherit" else not _is_clear(stroke),
            self.width if width is None else width,
            self.filled if fill == "inherit" else _is_ink(fill),
            (_is_nothing(values, "stroke-opacity", self.clear[0]), _is_nothing(values, "fill-opacity", self.clear[1])),
            self.hidden or values.get("display") == "none" or _is_nothing(values, "opacity", False),
            self.visible if seen == "inherit" else seen == "visible",
            self.even_odd if rule == "inherit" else rule == "evenodd",
            values.get("transform"),
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


def _is_ink(fill: str) -> bool:
    """Whether a fill stands out from white paper; gradients and patterns do."""
    from svgelements import Color

    if _is_clear(fill):
        return False
    try:
        return float(Color(fill[:64]).luma) < _PAPER
    except (AttributeError, ValueError, TypeError, IndexError):
        return True
