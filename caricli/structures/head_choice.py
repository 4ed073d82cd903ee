"""What a head is to consist of."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from caricli.structures.materials import HEAD_PARTS, Material

Teeth = Literal["natural", "cartoon"]
"""How teeth are modelled."""


@dataclass(frozen=True)
class HeadChoice:
    """What a head is to consist of, where there is a choice.

    parts: some of ``HEAD_PARTS``, the skin among them.
    shoulders: whether a bust that reaches to the shoulders takes the place of what closes the neck.
    teeth: how they are modelled, where they are not there already; None for natural ones, or those that are there.
    """

    parts: Sequence[str] = tuple(HEAD_PARTS)
    shoulders: bool = False
    teeth: Teeth | None = None

    @property
    def materials(self) -> list[Material]:
        """What these parts are made of."""
        names = {*self.parts} | ({"bust"} if self.shoulders else set())
        return [material for name, own in HEAD_PARTS.items() if name in names for material in own]

    def takes(self, materials: np.ndarray) -> bool:
        """Whether polygons of these materials (P,) are wanted, all of them."""
        return bool(np.isin(materials, self.materials).all())


WHOLE = HeadChoice()
"""All that a head has."""

BARE = HeadChoice(("skin",))
"""The skin alone."""
