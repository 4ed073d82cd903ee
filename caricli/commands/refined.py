"""What `caricli refine` reads and writes besides its options."""

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.face import write_face
from caricli.io.obj import write_obj
from caricli.io.parsing import read_parsing
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.reconstruct.snap_eyes import snap_eyes
from caricli.render.contact_sheet import contact_sheet
from caricli.render.fit_sheet import fit_sheet
from caricli.structures import Face

_EYE_NAMES = ("eye_left", "eye_right")


def snap_to_parsing(marks, path, pixels):
    """Points (L, 2) of Landmarks with the eyes' on the border of the parsed eyes, and how many moved."""
    if path is None:
        return marks.points, 0
    labels, legend = read_parsing(path)
    size = marks.image_size if pixels is None else pixels.shape[1::-1]
    if size is not None and tuple(size) != labels.shape[::-1]:
        found = f"{labels.shape[1]} x {labels.shape[0]}"
        raise InputError(f"{shown(path)}: expected the picture's size, {size[0]} x {size[1]}, found {found}")
    numbers = [legend[name] for name in _EYE_NAMES if name in legend]
    if not np.isin(labels, numbers).any():
        raise InputError(f"{shown(path)}: expected pixels labelled {' or '.join(_EYE_NAMES)}, found none")
    return snap_eyes(marks.points, labels, numbers)


def write_refined(files, found, seen, model, pose, points, pixels, fine):
    """Write OBJ and NPZ of a Refinement of a Face, and return the picture: before above after.

    files: paths, the OBJ's and the NPZ's first. The latent of the face stays; what it cannot express is the residual.
    """
    template = model.template
    finer = fine.weights @ found.vertices if fine.levels else found.vertices
    write_obj(files[0], fine.mesh.with_vertices(finer))
    code = None if seen.latent is None else encode_face(found.vertices, model, seen.latent)
    known = (None, None) if code is None else (code.latent, code.residual)
    model_id = None if code is None else model.model_id
    write_face(files[1], Face(template.with_vertices(found.vertices), pose, found.landmarks, *known, model_id))
    rows = []
    for vertices in (seen.vertices, found.vertices):
        drawn = Face(template.with_vertices(vertices), pose, pose.project(vertices[found.anchors]))
        rows.append(fit_sheet(drawn, template, points, pixels, 384))
    return contact_sheet(rows, 1, ["before", "after"])
