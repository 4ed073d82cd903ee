"""How far teeth show between the lips."""

import numpy as np

from caricli.structures import Material, Part
from caricli.template.template import Template

SHOWN = 0.6
"""Of an open mouth's height, what the upper teeth fill at least, and"""
CROWN = 0.75
"""of their own height, what shows of them at most."""

BARE = 0.62
"""Of the height of teeth, what stands out of the gums."""

NECK = 0.4
"""Of it, from the edge, where gums begin to rise between them: so far teeth grow, and gums stay as they are."""

LONGEST = 4.0
"""Times their height, what teeth grow to at most that a picture shows longer, and"""
BEHIND_LIPS = 1.4
"""where lips close before them."""

BEHIND = 0.01
"""Of the head's height, how much higher than the lip's rim they end at most."""

LAUGHED = 0.012
"""Of the head's height, how much lower than it they end at most where lips meet that were open in a laugh."""

LOWER = (-0.011, 0.005)
"""Of the head's height, how much higher than their lip's rim lower teeth end behind lips that meet, at least and at
most: those of eight of ten people without exaggeration do from 0.011 below it to 0.002 above."""

LEAN = 0.75
"""Of how far one lip is behind the other: with all of it teeth meet the wall behind that lip."""

_MIDDLE = 0.25
"""Of the width of the arch, how far incisors are from its middle."""

_COLUMNS = 8
"""Of teeth on either side, whose ends are told one by one."""


class Incisors:
    """The middle teeth of an arch, and the lips before them.

    A wall of the mouth that a laugh draws up takes the teeth along that stand by it, as none of a skull do: these are
    hidden then, where a drawing shows them.
    """

    def __init__(self, part: Part, lips: list[int]) -> None:
        """part: with teeth, on skull or jaw. lips: of ``lip_middles``."""
        self.lips = lips
        self.row = 0 if part.hangs_on == "skull" else 1
        # Teeth of the skull stand down, those of the jaw up.
        self.outwards = (-1, 1)[self.row]
        teeth = np.unique(part.mesh.polygons[part.materials == Material.TEETH])
        self.teeth = teeth[teeth >= 0]
        across, _, depth = np.asarray(part.mesh.vertices, float).T
        ends = across[self.teeth].min(), across[self.teeth].max()
        self.aside = np.abs(across - np.mean(ends)) / np.ptp(ends)
        aside = self.aside[self.teeth]
        # Fangs leave a gap in the middle; those beside it count.
        middle = self.teeth[aside < max(_MIDDLE, 2 * aside.min())]
        front = middle[depth[middle] > np.median(depth[middle])]
        self.front = front if len(front) else middle

    def edge(self, shape: np.ndarray, up: np.ndarray) -> float:
        """Where the teeth of a part (W, 3) end, metres along the way up (3,), of unit length."""
        return self.outwards * float((self.outwards * shape[self.front] @ up).max())

    def highest(self, skin: np.ndarray, shape: np.ndarray, up: np.ndarray, height: float) -> float:
        """Where the upper teeth of a part (W, 3) may end at most in a face (V, 3) of some height, metres upwards."""
        upper, lower = skin[self.lips] @ up
        shown = min(SHOWN * max(upper - lower, 0), CROWN * float(np.ptp(shape[self.front] @ up)))
        return float(upper - shown + max(BEHIND * height - shown, 0))

    def lifted(self, skin: np.ndarray, shape: np.ndarray, up: np.ndarray, height: float) -> float:
        """Metres by which the lower teeth of a part (W, 3) go up (3,) in a face (V, 3) of some height at rest."""
        upper, lower = skin[self.lips] @ up
        above = self.edge(shape, up) - float(lower)
        low, high = np.array(LOWER) * height + (0, max(upper - lower, 0))
        return float(np.clip(above, low, high)) - above

    def lowest(self, skin: np.ndarray, up: np.ndarray, height: float) -> float:
        """Where teeth that showed in a laugh may end at least in a face (V, 3) of some height, metres upwards."""
        return float(skin[self.lips[0]] @ up - LAUGHED * height)

    def as_pictured(
        self, skin: np.ndarray, shape: np.ndarray, up: np.ndarray, shown: float, height: float
    ) -> np.ndarray:
        """The part (W, 3) with its teeth beyond the rim of their lip as far as a picture shows them.

        They grow, so that no gum shows between lip and teeth, and lean as the way from lip to lip does. skin: (V, 3)
        metres, of a face of some height. up: (3,) of unit length. shown: metres; at 0 they are behind the lip.
        """
        own, other = skin[self.lips[self.row]], skin[self.lips[1 - self.row]]
        move = own @ up + self.outwards * (shown or -BEHIND * height) - self.edge(shape, up)
        if not shown:
            return shape + self.outwards * min(self.outwards * move, 0) * up
        placed = self.grown(shape, up, shown, LONGEST) + move * up
        across = other - own
        # Lips that meet tell no way.
        gap = max(self.outwards * float(across @ up), BEHIND * height)
        beyond = np.clip(self.outwards * (placed - own) @ up / gap, 0, 1)
        return placed + LEAN * np.outer(beyond, across - across @ up * up)

    def grown(self, shape: np.ndarray, up: np.ndarray, shown: float, most: float) -> np.ndarray:
        """The part (W, 3) with teeth so much longer, at most so many times, that they stand as far out of their gums as
        a picture shows them, metres; their edge stays. up: (3,) of unit length."""
        height = float(np.ptp(shape[self.front] @ up))
        crown = BARE * height
        longer = crown * (np.clip(shown / crown, 1, most) - 1)
        inwards = self._inwards(-self.outwards * (shape @ up))
        return shape - self.outwards * longer * np.outer(np.clip(inwards / (NECK * height), 0, 1), up)

    def _inwards(self, heights: np.ndarray) -> np.ndarray:
        """(W,) heights towards the gums from the ends of the teeth that are as far aside on, of heights (W,)."""
        column = np.minimum(2 * _COLUMNS * self.aside[self.teeth], _COLUMNS - 1).astype(int)
        ends = np.full(_COLUMNS, np.inf)
        np.minimum.at(ends, column, heights[self.teeth])
        there = np.flatnonzero(np.isfinite(ends))  # there may be gaps between teeth
        inwards: np.ndarray = heights - np.interp(2 * _COLUMNS * self.aside, there + 0.5, ends[there])
        return inwards


def incisors_of(template: Template, part: Part) -> Incisors | None:
    """The Incisors of a part, None where it has no teeth or the template does not tell its lips."""
    lips = lip_middles(template)
    has_teeth = bool((part.materials == Material.TEETH).any())
    return Incisors(part, lips) if lips and has_teeth and part.hangs_on in ("skull", "jaw") else None


def lip_middles(template: Template) -> list[int] | None:
    """The vertices in the middle of the inner rims of the upper and the lower lip, None where these are not told."""
    curves = template.annotation.curves
    rims = [curves[name] for name in ("mouth_inner_upper", "mouth_inner_lower") if name in curves]
    return [int(rim[len(rim) // 2]) for rim in rims] if len(rims) == 2 else None
