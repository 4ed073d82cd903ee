"""Whether meshes are of one set: of one size, in one place, upright like the others, and everybody's own."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.data.unseen import measures
from caricli.errors import InputError, shown
from caricli.geometry.alignment.similarity import similarity


@dataclass(frozen=True)
class AlikeSettings:
    """What a mesh may differ by from the usual one; generated faces and caricatures are far from all of these.

    height: ratio to the median one, or the inverse; those differ by up to 1.36, while units differ by 10.
    place: of a height, that the mean vertex is from the median one's place; those are up to 0.035 from it.
    turn: degrees to the first mesh; those are turned by up to 9, a head that lies or looks aside by 90 or more.
    same: metres, that every vertex of the same mesh is the same by, in whatever file and place.
    """

    height: float = 2.5
    place: float = 0.5
    turn: float = 60.0
    same: float = 1e-4


ALIKE = AlikeSettings()


def check_alike(files: Sequence[Path], shapes: np.ndarray) -> None:
    """Refuse meshes of which some are far from the size, the place or the direction of the others.

    files: N. shapes: (N, V, 3) vertices in any unit. Raises InputError that names the first of these and their number.
    """
    heights = np.ptp(shapes[..., 1], axis=1).astype(float)
    usual = float(np.median(heights))
    odd = (heights > ALIKE.height * usual) | (heights * ALIKE.height < usual)
    expected = f"a height of {usual / ALIKE.height:.3g} to {usual * ALIKE.height:.3g}, in the unit of the others"
    _refuse(files, odd, expected, [f"{height:.3g}" for height in heights])
    middles = shapes.mean(1, dtype=float)
    away = np.linalg.norm(middles - np.median(middles, axis=0), axis=1)
    expected = f"a head within {ALIKE.place * usual:.3g} of where the others are"
    _refuse(files, away > ALIKE.place * usual, expected, [f"it {distance:.3g} away" for distance in away])
    angles = np.array([_turn(shape, shapes[0]) for shape in shapes])
    turned = angles > ALIKE.turn
    # Where most are turned, the first is the one that is not like the others.
    if turned.mean() > 0.5:
        turned = ~turned
        angles[:] = np.median(angles)
    _refuse(files, turned, "a head turned as the others are", [f"it turned by {angle:.0f} degrees" for angle in angles])


def check_own(files: Sequence[Path], shapes: np.ndarray, people: Sequence[str]) -> None:
    """Refuse meshes of which two people have the very same: one is then trained with and tested with under two names.

    files, people: N. shapes: (N, V, 3) metres. Raises InputError that names both files.
    """
    alike: dict[bytes, list[int]] = defaultdict(list)
    for row, shape in enumerate(shapes):
        mark = measures(shape)
        for other in alike[mark]:
            if people[other] != people[row] and _same(shape, shapes[other]):
                raise InputError(
                    f"{shown(files[row])}: expected a mesh of {shown(people[row], 40)}'s own, found that of "
                    f"{shown(files[other].name)}, which is {shown(people[other], 40)}'s; name them alike, or leave one "
                    "out"
                )
        alike[mark].append(row)


def _refuse(files: Sequence[Path], odd: np.ndarray, expected: str, given: Sequence[str]) -> None:
    """Raise InputError about the first of the files that are odd (N,) bool, if any is. given: what each is, N texts."""
    if odd.any():
        first = int(odd.argmax())
        raise InputError(
            f"{shown(files[first])}: expected {expected}, found {given[first]} ({odd.sum()} such of {len(files)})"
        )


def _turn(shape: np.ndarray, other: np.ndarray) -> float:
    """Degrees of the rotation that brings a shape (V, 3) best onto another."""
    rotation = similarity(shape.astype(float), other.astype(float), scaling=False)[1]
    return float(np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))))


def _same(shape: np.ndarray, other: np.ndarray) -> bool:
    """Whether the vertices (V, 3) of two meshes lie alike around their middles."""
    apart = (shape - shape.mean(0, dtype=float)) - (other - other.mean(0, dtype=float))
    return bool(np.abs(apart).max() < ALIKE.same)
