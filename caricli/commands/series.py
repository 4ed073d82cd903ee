"""What commands share that write many faces of one model into a folder."""

import numpy as np

from caricli.io.face import write_face
from caricli.io.obj import write_obj
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.render.head_views import head_views
from caricli.structures import Face

_ROUNDING = 1e-6


def series_paths(folder, name, count, sheet):
    """Files of a series: OBJ and NPZ of every face in turn, named name-000 and so on; then PNG and JSON of a sheet."""
    faces = [folder / f"{name}-{number:03d}{suffix}" for number in range(count) for suffix in (".obj", ".npz")]
    return [*faces, folder / f"{sheet}.png", folder / f"{sheet}.json"]


def write_series_face(files, face, model, fine, source=None):
    """Write an EncodedFace as OBJ, on the FineMesh, and as NPZ, on the model's own mesh.

    files: paths of the OBJ and the NPZ. source: Face whose camera and landmarks go with it, where it has them.
    Returns the vertices of the OBJ.
    """
    template, obj_file, npz_file = model.template, *files
    finer = subdivide_face(face.vertices, face.latent, model, fine)
    write_obj(obj_file, fine.mesh.with_vertices(finer))
    residual = face.residual if np.abs(face.residual).max() > _ROUNDING else None
    seen = (None, None) if source is None else (source.camera, source.landmarks)
    write_face(npz_file, Face(template.with_vertices(face.vertices), *seen, face.latent, residual, model.model_id))
    return finer


def draw_series_face(face, finer, model, fine, size):
    """Front and three-quarter view of what ``write_series_face`` wrote."""
    head = model.template.with_vertices(face.vertices)
    return head_views(head, ("front", "three-quarter"), size, fine.with_vertices(finer))
