"""Portraits and what was made of them, a row each."""

import numpy as np

from caricli.methods.evaluate.evaluate_portrait import PortraitResult
from caricli.methods.parts.whole_head import whole_head
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.portrait_row import SIDES, portrait_row
from caricli.template.template import Template

SHOWN = ("morphable", "morphable + refine", "elastic + refine")
"""Methods whose faces are drawn; the last one's texture, too."""


class PortraitSheet:
    """A sheet that grows by a row with every portrait."""

    def __init__(self, template: Template, size: int) -> None:
        """template: of the faces. size: pixels, the longer side of a picture."""
        self.template = template
        self.size = size
        self.cells: list[np.ndarray] = []
        self.labels: list[str] = []

    def add(self, result: PortraitResult) -> None:
        """Draw a portrait: the picture, the faces of SHOWN in its place, and the textured head."""
        portrait = result.portrait
        faces = {name: (own.face, whole_head(own.face, self.template)) for name, own in result.reconstructions.items()}
        rig = result.rigs.get(SHOWN[-1], result.rigs["elastic"])
        fits = [faces.get(name) for name in SHOWN]
        self.cells += portrait_row(portrait.image, portrait.points, fits, rig, self.size)
        names = [name if name in faces else f"{name} refused" for name in SHOWN]
        self.labels += [portrait.name, *names, *["textured"] * len(SIDES)]

    @property
    def image(self) -> np.ndarray:
        """(H, W, 3) uint8 of all rows."""
        return contact_sheet(self.cells, 1 + len(SHOWN) + len(SIDES), self.labels)
