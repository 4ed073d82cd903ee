"""What of an SVG's style says whether and how a line is drawn."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(px|pt|pc|mm|cm|in|)\s*")
_UNITS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0}
_CLASS = re.compile(r"\.([\w-]+)\s*$")
_KEYS = ("stroke", "stroke-width", "display", "visibility")
_LARGEST = 1e9


def length_in_pixels(text: str | None) -> float | None:
    """A length such as ``12``, ``3.5mm`` or ``1in``, 96 pixels an inch; None where it is none, or a percentage."""
    match = _NUMBER.fullmatch(text[:64]) if text else None
    if match is None:
        return None
    value = float(match[1]) * _UNITS[match[2]]
    return value if abs(value) <= _LARGEST else None


def style_rules(text: str) -> dict[str, dict[str, str]]:
    """Declarations by class of a style sheet; other selectors than classes are passed over."""
    rules: dict[str, dict[str, str]] = {}
    for rule in text.split("}")[:-1]:
        before, _, body = rule.rpartition("{")
        declarations = _declarations(body)
        for selector in before.rpartition("{")[2].split(","):
            match = _CLASS.search(selector.strip())
            if match:
                rules.setdefault(match[1], {}).update(declarations)
    return rules


def _declarations(text: str) -> dict[str, str]:
    pairs = (entry.partition(":") for entry in text.split(";"))
    return {key.strip(): value.strip() for key, _, value in pairs if key.strip() in _KEYS}


@dataclass(frozen=True)
class Style:
    """How a line is drawn.

    stroked: with a stroke. width: of it, in units of the drawing, or None. hidden: not at all.
    """

    stroked: bool = False
    width: float | None = None
    hidden: bool = False

    def within(self, element: Element, rules: Mapping[str, Mapping[str, str]]) -> "Style":
        """The style of an element in one of this style. rules: as ``style_rules`` gives them."""
        values = {key: value for key in _KEYS if (value := element.get(key)) is not None}
        for word in (element.get("class") or "").split():
            values |= rules.get(word, {})
        values |= _declarations(element.get("style") or "")
        stroke = values.get("stroke", "inherit")
        width = length_in_pixels(values.get("stroke-width"))
        visibility = values.get("visibility", "inherit")
        return Style(
            self.stroked if stroke == "inherit" else stroke not in ("none", "transparent"),
            self.width if width is None else width,
            self.hidden or values.get("display") == "none" or visibility in ("hidden", "collapse"),
        )
