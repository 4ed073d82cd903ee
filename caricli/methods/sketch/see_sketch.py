"""A face from a sketch at one look: what the network makes of it."""

from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel
from caricli.structures import Face
from caricli.structures.sketch import Sketch


def see_sketch(sketch: Sketch, network: SketchModel, basis: ShapeModel) -> Face:
    """The face of a sketch (sketch paper, section 5.1, initial sketching).

    Strokes with names of curves count by their places, too; others by the picture alone.

    network: SketchModel. basis: ShapeModel whose latents it tells, as ``load_sketch_pair`` gives both.
    Returns Face with camera, in pixels of the sketch's canvas, and latent. Raises InputError where nothing is drawn.
    """
    latent, camera = network.reconstruct(sketch)
    mesh = basis.template.with_vertices(basis.decode(latent))
    return Face(mesh, camera, latent=latent, model_id=basis.model_id)
