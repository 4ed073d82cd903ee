"""The face of a network, to follow lines from."""

from dataclasses import replace
from typing import TYPE_CHECKING

from caricli.methods.sketch.fit_lines import Lines, line_camera
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.structures.sketch import Sketch

if TYPE_CHECKING:
    from caricli.models.sketch.model import SketchModel


def network_coarse(
    sketch: Sketch, lines: Lines, handles: LineHandles, network: "SketchModel", model: ShapeModel
) -> Face:
    """What ``see_sketch`` gives, seen by the camera that the lines tell.

    sketch: Sketch. lines: of it, by curves. handles: LineHandles of the model's template. network: SketchModel.
    model: ShapeModel whose latents it tells. Raises InputError where the lines are not enough to tell a face:
    a network sees one in anything.
    """
    face = see_sketch(sketch, network, model)
    points = face.vertices[handles.vertices]
    return replace(face, camera=line_camera(lines, handles, points, start=face.require_camera()))
