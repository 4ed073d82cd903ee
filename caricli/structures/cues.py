"""What a mouth says, sound by sound."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import shown
from caricli.structures.checks import refuse

RHUBARB = "ABCDEFGHX"
"""The mouth shapes of Rhubarb Lip Sync; A is closed, X is at rest."""

VISEMES = ("sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou")
"""The fifteen visemes of OVR LipSync, which engines and avatars share."""

REST = "viseme_sil"
SHAPES = tuple(f"rhubarb_{letter}" for letter in RHUBARB) + tuple(f"viseme_{name}" for name in VISEMES)
"""What a mouth can show: names that tell Rhubarb's E from the viseme E."""

_OTHERS = {"i": "ih", "o": "oh", "u": "ou"}
"""Visemes by what avatars call them."""


def viseme_name(name: str) -> str | None:
    """The one of SHAPES that a viseme's name means, with "viseme_" before it or without; None where there is none."""
    bare = name.lower().removeprefix("viseme_")
    visemes = {viseme.lower(): viseme for viseme in VISEMES}
    viseme = visemes.get(_OTHERS.get(bare, bare))
    return None if viseme is None else f"viseme_{viseme}"


@dataclass(frozen=True, eq=False)
class Cues:
    """Shapes of a mouth, one after the other.

    names: (N,) of SHAPES. starts: (N,) seconds, rising from 0; each lasts until the next. end: seconds, of the last.
    Raises InputError when the parts do not fit each other.
    """

    names: tuple[str, ...]
    starts: np.ndarray
    end: float

    def __post_init__(self) -> None:
        """Check names and times."""
        strange = next((name for name in self.names if name not in SHAPES), None)
        if strange is not None or not self.names:
            refuse(f"cues: expected names of {', '.join(SHAPES)}, found {shown(strange, 40)}")
        edges = np.append(self.starts, self.end)
        if len(edges) != len(self.names) + 1 or not np.isfinite(edges).all() or edges[0] != 0:
            refuse(f"cues: expected {len(self.names)} times from 0 on, found others")
        if (np.diff(edges) <= 0).any():
            row = int(np.argmax(np.diff(edges) <= 0))
            refuse(f"cues: expected rising times, found {edges[row + 1]:g} s after {edges[row]:g} s")
