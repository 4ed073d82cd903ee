"""caricli reconstruct-from-landmarks: 2D landmarks to a 3D caricature."""

import time
from dataclasses import asdict

import click
import numpy as np

from caricli.commands.options import PATH, image_option, model_option, out_folder_option, out_option, overwrite_option
from caricli.errors import InputError
from caricli.io.face import Face, write_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import check_inside, read_landmarks
from caricli.io.obj import write_obj
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SUFFIXES = (".obj", ".npz", ".json", ".png")
PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".gif")


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
    type=click.FloatRange(0.01, 100),
    default=1.0,
    metavar="W",
    help="Larger stays nearer to plausible faces, smaller nearer to the landmarks.",
)
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@overwrite_option
@click.pass_context
def command(ctx, landmarks, out, out_dir, image, method, model, prior_weight, pts_origin, overwrite):
    """Reconstruct 3D caricatures from 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    With several LANDMARKS --image is a folder of pictures with the same names. In the picture that is written, green
    circles are the given landmarks and red dots the fitted ones.

    \b
    Example:
      caricli reconstruct-from-landmarks landmarks.json --image drawing.png --out face.obj
      caricli reconstruct-from-landmarks marks/*.txt --image drawings --out-dir faces
    """
    from caricli.commands.batch import run_batch
    from caricli.commands.loading import load_model
    from caricli.methods.fit_landmarks import fit_landmarks

    if (out is None) == (out_dir is None):
        raise click.UsageError("Give either --out for one result or --out-dir for many.")
    if out is not None and (len(landmarks) > 1 or out.suffix.lower() != ".obj"):
        raise click.UsageError("--out takes one LANDMARKS and a name that ends in .obj; for more use --out-dir.")
    jobs = [(path, out or out_dir / f"{path.stem}.obj") for path in landmarks]
    if len({target for _, target in jobs}) < len(jobs):
        raise click.UsageError("Two LANDMARKS have the same name; their results would replace each other.")
    shape_model = load_model(model, "intrinsic" if method == "intrinsic" else "pca")
    shape_model.prepare()
    known = {"method": method, "prior_weight": prior_weight, "model_id": shape_model.model_id}

    def reconstruct(path, target):
        picture = image if out is not None else _picture_beside(image, path)
        paths = [target.with_suffix(suffix) for suffix in SUFFIXES]
        with staged(*paths, overwrite=overwrite, inputs=(*landmarks, model, picture)) as files:
            marks = read_landmarks(path, pts_origin)
            pixels = None if picture is None else _picture(picture, marks, path)
            start = time.perf_counter()
            fit = fit_landmarks(marks.points, shape_model, method, prior_weight)
            seconds = time.perf_counter() - start
            description = provenance("reconstruct-from-landmarks", [path, picture], **known) | _figures(fit, seconds)
            _write(files, shape_model, fit, marks.points, pixels, description)
        quality = f"NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}, flipped {100 * fit.flipped:.2f} %"
        return f"{target}: {quality}, {seconds:.2f} s"

    run_batch(ctx, jobs, reconstruct, "faces")


def _write(files, model, fit, given, image, description):
    """Write OBJ, NPZ, JSON and the picture of a fit."""
    from caricli.commands.loading import template_mesh
    from caricli.render.fit_sheet import fit_sheet

    obj_file, npz_file, json_file, png_file = files
    template, camera = model.template, (fit.pose.scale, fit.pose.rotation, fit.pose.translation)
    write_obj(obj_file, template_mesh(template, fit.vertices))
    mesh = (template.polygons, template.uvs, template.uv_polygons)
    fitted = (fit.latent, fit.residual, *camera, fit.landmarks, model.model_id)
    write_face(npz_file, Face(fit.vertices, template.faces, *fitted, *mesh))
    write_json(json_file, description)
    annotation = template.annotation
    write_png(png_file, fit_sheet(fit.vertices, template.faces, annotation, given, fit.landmarks, camera, image))


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


def _picture(image, marks, path):
    """The picture, if the landmarks can belong to it."""
    picture = read_image(image)
    size = picture.shape[1], picture.shape[0]
    if marks.image_size is not None and tuple(marks.image_size) != size:
        found = "{} x {}".format(*marks.image_size)
        raise InputError(f"{path}: expected landmarks of the {size[0]} x {size[1]} picture {image}, found {found}")
    check_inside(marks.points, size, path)
    return picture


def _picture_beside(folder, path):
    """The picture in a folder that has the name of a landmark file."""
    if folder is None:
        return None
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of pictures, because results of many inputs were asked for")
    found = [folder / f"{path.stem}{suffix}" for suffix in PICTURES if (folder / f"{path.stem}{suffix}").is_file()]
    if not found:
        raise InputError(f"{folder}: expected a picture named {path.stem} with one of {', '.join(PICTURES)}")
    return found[0]
