"""caricli reconstruct-from-landmarks: 2D landmarks to a 3D caricature."""

import time
from dataclasses import asdict

import click
import numpy as np

from caricli.commands.options import (
    PATH,
    FiniteRange,
    face_files,
    image_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.io.face import Face, write_face
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.obj import write_obj
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@click.argument("landmarks", nargs=-1, required=True, type=PATH, metavar="LANDMARKS...")
@out_option("FACE.obj", "The result of one input; FACE.npz, .json and .png are written beside it.", required=False)
@out_folder_option("The results of many inputs, each under the name of its file.")
@image_option
@click.option(
    "--method",
    type=click.Choice(["intrinsic", "latent"]),
    default="intrinsic",
    help="Let the surface follow the landmarks elastically, or stay inside the model.",
)
@model_option
@click.option(
    "--prior-weight",
    type=FiniteRange(0.01, 100),
    default=1.0,
    metavar="W",
    help="Larger stays nearer to plausible faces, smaller nearer to the landmarks.",
)
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@subdivide_option
@overwrite_option
@click.pass_context
def command(ctx, landmarks, out, out_dir, image, method, model, prior_weight, pts_origin, levels, overwrite):
    """Reconstruct 3D caricatures from 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    With several LANDMARKS --image is a folder of pictures with the same names. In the picture that is written, green
    circles are the given landmarks and red dots the fitted ones.

    \b
    Example:
      caricli reconstruct-from-landmarks landmarks.json --image drawing.png --out face.obj
      caricli reconstruct-from-landmarks marks/*.txt --image drawings --out-dir faces
    """
    from caricli.commands.batch import named_jobs, run_batch
    from caricli.commands.loading import DEFAULT_LATENT, load_model
    from caricli.commands.pictures import picture_beside, read_picture
    from caricli.methods.fit_landmarks import fit_landmarks
    from caricli.template.fine_mesh import fine_mesh

    jobs = named_jobs(landmarks, "LANDMARKS", out, out_dir, ".obj")
    shape_model = load_model(model, "intrinsic" if method == "intrinsic" else DEFAULT_LATENT)
    shape_model.prepare()
    fine = fine_mesh(shape_model.template, levels)
    known = {"method": method, "prior_weight": prior_weight, "model_id": shape_model.model_id, "subdivide": levels}

    def reconstruct(path, target):
        picture = image if out is not None else picture_beside(image, path)
        paths = face_files(target)
        with staged(*paths, overwrite=overwrite, inputs=(*landmarks, model, picture)) as files:
            marks = read_landmarks(path, pts_origin)
            pixels = None if picture is None else read_picture(picture, marks, path)
            start = time.perf_counter()
            fit = fit_landmarks(marks.points, shape_model, method, prior_weight)
            seconds = time.perf_counter() - start
            description = provenance("reconstruct-from-landmarks", [path, picture], **known) | _figures(fit, seconds)
            _write(files, shape_model, fit, fine, marks.points, pixels, description)
        quality = f"NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}, flipped {100 * fit.flipped:.2f} %"
        return f"{target}: {quality}, {seconds:.2f} s"

    run_batch(ctx, jobs, reconstruct, "faces")


def _write(files, model, fit, fine, given, image, description):
    """Write OBJ, NPZ, JSON and the picture of a fit."""
    from caricli.commands.loading import template_mesh
    from caricli.methods.subdivide_face import subdivide_face
    from caricli.render.fit_sheet import fit_sheet

    obj_file, npz_file, json_file, png_file = files
    template, camera = model.template, (fit.pose.scale, fit.pose.rotation, fit.pose.translation)
    fine_vertices = subdivide_face(fit.vertices, fit.latent, model, fine)
    write_obj(obj_file, template_mesh(fine, fine_vertices))
    mesh = (template.polygons, template.uvs, template.uv_polygons)
    fitted = (fit.latent, fit.residual, *camera, fit.landmarks, model.model_id)
    write_face(npz_file, Face(fit.vertices, template.faces, *fitted, *mesh))
    write_json(json_file, description)
    drawn = (fine_vertices, fine.faces, fine.weights)
    shown = (fit.vertices, template.faces, template.annotation, given, fit.landmarks, camera, image)
    write_png(png_file, fit_sheet(*shown, fine=drawn))


def _figures(fit, seconds):
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
