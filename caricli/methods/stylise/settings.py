"""How portraits are stylised."""

from dataclasses import dataclass, field

from caricli.geometry.deformation.smooth_displacement import Smoothness
from caricli.methods.edit.settings import MODES

SHAPES = ("map", *MODES, "none")
"""What a face becomes: as the landmark map sees it, more like all caricatures, more like itself, or what it is."""

STYLES = ("oil", "watercolour", "ink", "flat", "pencil", "none")
"""What the picture is painted with; with "none" its pixels stay."""


@dataclass(frozen=True)
class WarpSettings:
    """How a picture follows a mesh; lengths are shares of the diagonal of the landmarks.

    cell: side of the cells in which the displacement is solved for, of one pixel at least.
    margin: how far around the head, of which the mesh is all but hair, the picture gives way.
    smoothness: of the displacement, in cells.
    facing: least cosine at which the surface, seen from the camera, says where its pixels go.
    depth: how much farther away than what is seen there a point may lie that is still seen.
    """

    cell: float = 1 / 40
    margin: float = 1.0
    smoothness: Smoothness = field(default_factory=lambda: Smoothness(length=1.5, least=0.2))
    facing: float = 0.05
    depth: float = 1 / 40


@dataclass(frozen=True)
class StyliseSettings:
    """What is done with a portrait.

    style: of STYLES. shape: of SHAPES. strength: of the shape, 0 changes nothing, 1 shows clearly, 2 is strong. seed:
    of grain and strokes. warp: WarpSettings.
    """

    style: str = "oil"
    shape: str = "map"
    strength: float = 1.0
    seed: int = 0
    warp: WarpSettings = field(default_factory=WarpSettings)
