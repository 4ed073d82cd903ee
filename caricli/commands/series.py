"""What commands share that write many faces of one model into a folder."""

import numpy as np

from caricli.commands.loading import template_mesh
from caricli.io.face import Face, write_face
from caricli.io.obj import write_obj
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.render.head_views import head_views

_ROUNDING = 1e-6
_SEEN = ("camera_scale", "camera_rotation", "camera_translation", "landmarks")


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
    write_obj(obj_file, template_mesh(fine, finer))
    mesh = {"polygons": template.polygons, "uvs": template.uvs, "uv_polygons": template.uv_polygons}
    residual = face.residual if np.abs(face.residual).max() > _ROUNDING else None
    known = {"latent": face.latent, "residual": residual, "model_id": model.model_id}
    known |= {} if source is None else {key: getattr(source, key) for key in _SEEN}
    write_face(npz_file, Face(face.vertices, template.faces, **known, **mesh))
    return finer


def draw_series_face(face, finer, model, fine, size):
    """Front and three-quarter view of what ``write_series_face`` wrote."""
    mesh, drawn = (face.vertices, model.template.faces, model.template.annotation), (finer, fine.faces, fine.weights)
    return head_views(*mesh, ("front", "three-quarter"), size, drawn)
