"""What the commands share that fit a face to landmarks: its files and figures."""

from dataclasses import asdict

import numpy as np

from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.obj import write_obj
from caricli.io.strict_json import write_json
from caricli.structures import Face


def write_fit(files, model, fit, fine, given, image, description):
    """Write OBJ, NPZ, JSON and the picture of a LandmarkFit.

    files: the four paths. model: ShapeModel. fine: FineMesh of the OBJ. given: (L, 2) landmarks. image: (H, W, 3) or
    None. description: JSON value.
    """
    from caricli.methods.faces.subdivide_face import subdivide_face
    from caricli.render.fit_sheet import fit_sheet

    obj_file, npz_file, json_file, png_file = files
    template = model.template
    fine_vertices = subdivide_face(fit.vertices, fit.latent, model, fine)
    finer = fine.with_vertices(fine_vertices)
    write_obj(obj_file, finer.mesh)
    fitted = (fit.pose, fit.landmarks, fit.latent, fit.residual, model.model_id)
    face = Face(template.with_vertices(fit.vertices), *fitted)
    write_face(npz_file, face)
    write_json(json_file, description)
    write_png(png_file, fit_sheet(face, template, given, image, fine=finer))


def fit_figures(fit, seconds):
    """What the JSON says of a fit."""
    pose = {
        "scale": fit.pose.scale,
        "rotation": fit.pose.rotation,
        "translation": fit.pose.translation,
        "convention": "pixels = scale * rotation[:2] @ vertex + translation; x right, y down, z into the picture",
    }
    return {
        "settings": asdict(fit.settings),
        "nme": fit.nme,
        "nme_latent": fit.nme_latent,
        "part_errors": fit.part_errors,
        "prior_rms": fit.prior_rms,
        "flipped": fit.flipped,
        "pose": pose,
        "anchors": np.asarray(fit.anchors),
        "iterations": fit.rounds,
        "seconds": seconds,
    }
