"""Who a mesh shows, with which expression and how exaggerated, as the names of files say it."""

import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from caricli.data.expressions import NEUTRAL
from caricli.errors import InputError, shown
from caricli.io.parse_number import parse_whole
from caricli.structures.arkit import arkit_name, is_half

BETWEEN = "__"
"""What parts person, expression and level in the name of a file."""

GENERIC = "generic"
"""The person whose expressions have no other name in front of them."""


@dataclass(frozen=True)
class MeshName:
    """person and expression: names. level: of exaggeration, 1 for a face as it is."""

    person: str
    expression: str = NEUTRAL
    level: int = 1


def normal_name(text: str) -> str:
    """The one form of a name that is written the same: NFC of Unicode's, where macOS writes NFD, no blanks around."""
    return unicodedata.normalize("NFC", text).strip()


def read_mesh_name(stem: str) -> MeshName:
    """What the name of a file without its suffix says.

    ``anna__jawOpen__2`` is the person anna with the expression jawOpen at level 2; ``anna__jawOpen`` the same as it is,
    and ``anna`` her neutral face. Names have the form of ``normal_name``, expressions the spelling of
    ``expression_name``. A name that is an expression of ARKit's, or means one (``eyeBlink_L``), is one of a person
    GENERIC, as is ``neutral`` and what starts with ``generic_neutral``.
    Raises InputError for a level that is no whole number from 1.
    """
    stem = normal_name(stem)
    person, *rest = map(normal_name, stem.split(BETWEEN))
    if not rest:
        if stem.lower() == NEUTRAL or stem.lower().startswith(f"{GENERIC}_{NEUTRAL}"):
            return MeshName(GENERIC)
        return MeshName(GENERIC, expression_name(stem)) if arkit_name(stem) else MeshName(stem)
    expression, level, *more = [*rest, "1"] if len(rest) == 1 else rest
    if more or not person or not expression:
        raise InputError(f"expected a name such as anna{BETWEEN}jawOpen{BETWEEN}2, found {stem!r}")
    return MeshName(person, expression_name(expression), read_level(level))


def expression_name(text: str) -> str:
    """The one spelling of an expression: NEUTRAL in any capitals, and ARKit's of what means one of its actions; half
    of one (``browInnerUp_L``) and all else keep theirs."""
    if text.lower() == NEUTRAL:
        return NEUTRAL
    return text if is_half(text) else arkit_name(text) or text


def check_capitals(what: str, names: Iterable[str]) -> None:
    """Refuse names of whom or of what (``what``) that are another only by their capitals. Raises InputError."""
    first: dict[str, str] = {}
    for name in names:
        other = first.setdefault(normal_name(name).casefold(), name)
        if other != name:
            raise InputError(f"expected {what} of one spelling, found {shown(other, 40)!r} and {shown(name, 40)!r}")


def read_level(text: str) -> int:
    """A level of exaggeration. Raises InputError for what is no whole number from 1 to 1000."""
    try:
        level = parse_whole(text)
    except ValueError:
        level = 0
    if not 1 <= level <= 1000:
        raise InputError(f"expected a level from 1 (as it is) to 1000, found {shown(text, 40)!r}")
    return level
