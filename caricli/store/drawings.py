"""Models together with how their faces are written and drawn."""

from pathlib import Path

from caricli.methods.faces.draw_face import FaceDrawing
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import HeadChoice
from caricli.template.fine_mesh import fine_mesh


def load_drawing(path: Path | None, levels: int, size: int, head: HeadChoice | None = None) -> FaceDrawing:
    """The FaceDrawing of a model.

    path: of the model, or None for the bundled one of latents. levels: how often polygons are split. size: pixels.
    head: HeadChoice, or None, as of FaceDrawing.
    Raises InputError when it is no model, or so fine a mesh is beyond the caps.
    """
    model = load_model(path, DEFAULT_LATENT)
    return FaceDrawing(model, fine_mesh(model.template, levels), size, head)
