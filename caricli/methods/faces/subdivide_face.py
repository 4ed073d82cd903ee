"""A face on a finer mesh."""

from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.template.fine_mesh import FineMesh, fine_mesh, split_materials


def subdivide_face(face: Face, model: ShapeModel, fine: FineMesh) -> FineMesh:
    """Decode a face's latent on a finer mesh and add what the face has beyond it, carried along linearly.

    A face with polygons or UVs of its own has these split instead of the model's.

    face: Face of the model's topology; one without a latent is carried along as a whole.
    model: ShapeModel of the latent.
    fine: FineMesh of the model's template.
    Returns the FineMesh in the shape of the face, whose own vertices come first.
    """
    template = model.template
    if len(face.mesh.polygons) != len(template.polygons) or not face.mesh.same_layout(template):
        fine = fine_mesh(face.mesh, fine.levels)
    if not fine.levels or face.latent is None:
        return fine.shaped(face.vertices)
    beyond = face.vertices - model.decode(face.latent)
    return fine.with_vertices(model.decode_on(face.latent, fine.weights) + fine.weights @ beyond)


def finer_face(face: Face, fine: FineMesh) -> Face:
    """The skin of a face on a FineMesh in its shape, with what it wears alone."""
    materials = split_materials(face.materials, face.mesh.polygons, fine.levels)
    return Face(fine.mesh, pictures=face.pictures, materials=materials)
