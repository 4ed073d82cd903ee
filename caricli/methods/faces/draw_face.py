"""Pictures of faces as they are written: on the finer mesh, with eyeballs."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from caricli.methods.faces.subdivide_face import finer_face, subdivide_face
from caricli.methods.parts.whole_head import mesh_face, whole_head
from caricli.models.shape_model import ShapeModel
from caricli.render.coat import mesh_coat
from caricli.render.head_views import head_views
from caricli.render.shade import Look
from caricli.structures import Face, HeadChoice
from caricli.structures.head_choice import WHOLE
from caricli.template.fine_mesh import FineMesh

VIEWS = ("front", "three-quarter")
"""What shows most of a head where many are drawn."""


@dataclass(frozen=True, eq=False)
class FaceDrawing:
    """How the faces of a model are drawn.

    model: ShapeModel. fine: FineMesh of its template. size: pixels, width and height of a picture.
    head: HeadChoice, or None where none was made: pictures show whole heads then, and meshes are the skin.
    """

    model: ShapeModel
    fine: FineMesh
    size: int
    head: HeadChoice | None = None

    def finer(self, face: Face) -> FineMesh:
        """The FineMesh in the shape of a Face of the model's topology."""
        return subdivide_face(face, self.model, self.fine)

    def mesh_face(self, face: Face) -> Face:
        """What a mesh file holds of a Face of the model's topology: its skin, or the head that was chosen."""
        return mesh_face(face, self.model.template, self.head, self.finer(face))

    def draw(self, face: Face, views: Iterable[str] = VIEWS) -> list[np.ndarray]:
        """Draw a whole head from several sides, in the pictures that its face wears.

        face: Face of the model's topology. views: as in ``render_views``.
        Returns a list of (size, size, 4) uint8.
        """
        finer = self.finer(face)
        shown = finer_face(face, finer)
        coat = mesh_coat(shown.mesh, shown.pictures, shown.triangle_materials)
        return head_views(
            whole_head(face, self.model.template, self.head or WHOLE), views, self.size, finer, Look(coat=coat)
        )
