"""What to build, and how random draws are made."""

from dataclasses import dataclass
from enum import IntFlag
from typing import ClassVar

from caricli.errors import InputError

KINDS = ("regular", "curvature", "parts", "curvature and parts")
"""What a mesh was exaggerated by; its number is that of an Exaggeration."""

OWN_KINDS = (*KINDS, "own features", "own features and curvature", "own features and parts")
"""Likewise in a dataset of OwnSettings, where only the first, the fifth and the last are."""

EXPONENTS = (0.0, 0.1, 0.2, 0.3)
"""Of the curvature, by level: see ``exaggerate_curvature``."""

MAX_IDENTITIES = 100_000
MAX_EXPRESSIONS = 25


class Exaggeration(IntFlag):
    """By what a mesh is exaggerated, as it is written into datasets."""

    CURVATURE = 1
    PARTS = 2
    OWN = 4


@dataclass(frozen=True)
class DrawSettings:
    """How random meshes are drawn.

    shares: of the draws that are of each of KINDS. strength: of the changes of parts, uniform from low to high.
    max_flipped: share of the triangles that may be flipped; a mesh with more is drawn anew, its changes of parts
    milder by the factor milder, tries times at most. person_tries: draws of a person until no triangle is flipped.
    """

    shares: tuple[float, ...] = (0.15, 0.15, 0.35, 0.35)
    strength: tuple[float, float] = (0.75, 1.6)
    max_flipped: float = 0.0008
    milder: float = 0.93
    tries: int = 30
    person_tries: int = 200


DRAW = DrawSettings()


@dataclass(frozen=True)
class BuildSettings:
    """What to build: without count the full grid, with it that many random draws.

    identities: people. expressions: the first ones of the table. levels: of exaggeration by curvature, none included;
    with one nothing is exaggerated, by parts neither.
    Raises InputError for sizes that cannot be built.
    """

    count: int | None = None
    identities: int = 150
    expressions: int = MAX_EXPRESSIONS
    levels: int = len(EXPONENTS)
    seed: int = 0

    kinds: ClassVar[tuple[str, ...]] = KINDS

    def __post_init__(self) -> None:
        """Refuse sizes that cannot be built."""
        limits = {"identities": MAX_IDENTITIES, "expressions": MAX_EXPRESSIONS, "levels": len(EXPONENTS)}
        for name, most in limits.items():
            if not 1 <= getattr(self, name) <= most:
                raise InputError(f"{name} must be from 1 to {most}, found {getattr(self, name)}")
        if self.count is not None and self.count < 1:
            raise InputError(f"count must be at least 1, found {self.count}")


@dataclass(frozen=True)
class OwnSettings(BuildSettings):
    """Random draws of people whose own features are exaggerated (``exaggerate_own``).

    regular: share of the draws that are not exaggerated; with one level all. parts: share of those that are of which
    parts are changed, too. strength: of these changes, uniform from low to high.
    Raises InputError without a count, too.
    """

    regular: float = 0.12
    parts: float = 0.85
    strength: tuple[float, float] = DRAW.strength

    kinds: ClassVar[tuple[str, ...]] = OWN_KINDS

    def __post_init__(self) -> None:
        """Refuse sizes that cannot be built."""
        super().__post_init__()
        if self.count is None:
            raise InputError("own features are exaggerated in random draws: expected a count, found none")
        for name in ("regular", "parts"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"{name} must be from 0 to 1, found {getattr(self, name)}")
