"""Pictures of faces as they are written: on the finer mesh, with eyeballs."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.models.shape_model import ShapeModel
from caricli.render.head_views import head_views
from caricli.structures import Face
from caricli.template.fine_mesh import FineMesh

VIEWS = ("front", "three-quarter")
"""What shows most of a head where many are drawn."""


@dataclass(frozen=True, eq=False)
class FaceDrawing:
    """How the faces of a model are drawn.

    model: ShapeModel. fine: FineMesh of its template. size: pixels, width and height of a picture.
    """

    model: ShapeModel
    fine: FineMesh
    size: int

    def draw(self, face: Face, views: Iterable[str] = VIEWS, finer: FineMesh | None = None) -> list[np.ndarray]:
        """Draw a face from several sides.

        face: Face of the model's topology. views: as in ``render_views``. finer: the face's ``subdivide_face``, where
        there is one already.
        Returns a list of (size, size, 4) uint8.
        """
        finer = subdivide_face(face, self.model, self.fine) if finer is None else finer
        return head_views(self.model.template.with_vertices(face.vertices), views, self.size, finer)
