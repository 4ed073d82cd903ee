"""Expressions of caricatures by every method, a row each."""

import numpy as np

from caricli.methods.evaluate.evaluate_blendshapes import Comparison
from caricli.methods.expressions.build_blendshapes import Blendshapes, build_blendshapes
from caricli.methods.expressions.rig_blendshapes import rig_blendshapes
from caricli.methods.expressions.settings import METHODS, BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.make_rig import RigSettings
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.expression_row import expression_row
from caricli.structures import Face, Pictures


class BlendshapeSheet:
    """A sheet that grows by rows: the face as it was given, and some of its expressions."""

    def __init__(self, tools: ExpressionTools, names: tuple[str, ...], size: int) -> None:
        """names: of the expressions that are drawn. size: pixels of a picture."""
        self.tools = tools
        self.names = names
        self.size = size
        self.cells: list[np.ndarray] = []
        self.labels: list[str] = []

    def add_comparison(self, comparison: Comparison) -> None:
        """Draw a caricature by every rival."""
        for name, blendshapes in comparison.blendshapes.items():
            self._add(name, blendshapes, comparison.face, Pictures())

    def add_face(self, name: str, face: Face, pictures: Pictures) -> None:
        """Build the expressions of a real caricature by every method, and draw them. pictures: on the face."""
        for method in METHODS:
            blendshapes = build_blendshapes(face, self.tools, BlendshapeSettings(method))
            self._add(f"{name}: {method}", blendshapes, face, pictures)

    @property
    def image(self) -> np.ndarray:
        """(H, W, 3) uint8 of all rows."""
        return contact_sheet(self.cells, 1 + len(self.names), self.labels)

    def _add(self, label: str, blendshapes: Blendshapes, face: Face, pictures: Pictures) -> None:
        result = rig_blendshapes(blendshapes, self.tools, RigSettings(), pictures, face)
        self.cells += expression_row(result.rig, result.as_given(face), self.names, self.size)
        self.labels += [label, *self.names]
