"""What of an SVG's style says whether and how a line is drawn."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(px|pt|pc|mm|cm|in|)\s*")
_UNITS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0}
_SELECTOR = re.compile(r"([.#][\w-]+|(?:^|(?<=[\s>+~]))(?:[\w-]+|\*))$")
_KEYS = ("stroke", "stroke-width", "fill", "fill-rule", "display", "visibility")
_LARGEST = 1e9
_PAPER = 0.8
"""Luma, 0 to 1, of what is no ink, at least."""


def length_in_pixels(text: str | None) -> float | None:
    """A length such as ``12``, ``3.5mm`` or ``1in``, 96 pixels an inch; None where it is none, or a percentage."""
    match = _NUMBER.fullmatch(text[:64]) if text else None
    if match is None:
        return None
    value = float(match[1]) * _UNITS[match[2]]
    return value if abs(value) <= _LARGEST else None


def style_rules(text: str) -> dict[str, dict[str, str]]:
    """Declarations of a style sheet by ``.class``, ``#id``, the name of an element or ``*``: each what a selector ends
    with. Other selectors are passed over."""
    rules: dict[str, dict[str, str]] = {}
    for rule in text.split("}")[:-1]:
        before, _, body = rule.rpartition("{")
        declarations = _declarations(body)
        for selector in before.rpartition("{")[2].split(","):
            match = _SELECTOR.search(selector.strip())
            if match:
                rules.setdefault(match[1], {}).update(declarations)
    return rules


def _declarations(text: str) -> dict[str, str]:
    pairs = (entry.partition(":") for entry in text.split(";"))
    return {key.strip(): value.strip() for key, _, value in pairs if key.strip() in _KEYS}


@dataclass(frozen=True)
class Style:
    """How a line is drawn.

    stroked: with a stroke. width: of it, in units of the drawing, or None. hidden: not at all. inked: filled with what
    is no paper, which is bright. even_odd: by which rule it is filled.
    """

    stroked: bool = False
    width: float | None = None
    hidden: bool = False
    inked: bool = True
    even_odd: bool = False

    def within(self, element: Element, rules: Mapping[str, Mapping[str, str]]) -> "Style":
        """The style of an element in one of this style. rules: as ``style_rules`` gives them."""
        values = {key: value for key in _KEYS if (value := element.get(key)) is not None}
        classes = [f".{word}" for word in (element.get("class") or "").split()]
        for key in ("*", str(element.tag).rpartition("}")[2], *classes, f"#{element.get('id')}"):
            values |= rules.get(key, {})
        values |= _declarations(element.get("style") or "")
        stroke = values.get("stroke", "inherit")
        width = length_in_pixels(values.get("stroke-width"))
        fill = values.get("fill", "inherit")
        rule = values.get("fill-rule", "inherit")
        visibility = values.get("visibility", "inherit")
        return Style(
            self.stroked if stroke == "inherit" else stroke not in ("none", "transparent"),
            self.width if width is None else width,
            self.hidden or values.get("display") == "none" or visibility in ("hidden", "collapse"),
            self.inked if fill == "inherit" else _is_ink(fill),
            self.even_odd if rule == "inherit" else rule == "evenodd",
        )


def _is_ink(fill: str) -> bool:
    """Whether a fill stands out from white paper; gradients and patterns do."""
    from svgelements import Color

    if fill in ("none", "transparent"):
        return False
    try:
        return float(Color(fill[:64]).luma) < _PAPER
    except (AttributeError, ValueError, TypeError, IndexError):
        return True
