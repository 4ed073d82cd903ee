"""caricli reconstruct-from-landmarks: 2D landmarks to a 3D caricature."""

import time
from dataclasses import asdict

import click
import numpy as np

from caricli.commands.options import PATH, image_option, model_option, out_folder_option, out_option, overwrite_option
from caricli.errors import CaricliError, InputError
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
    from caricli.commands.loading import load_model, progress_bar

    if (out is None) == (out_dir is None):
        raise click.UsageError("Give either --out for one result or --out-dir for many.")
    if out is not None and (len(landmarks) > 1 or out.suffix.lower() != ".obj"):
        raise click.UsageError("--out takes one LANDMARKS and a name that ends in .obj; for more use --out-dir.")
    shape_model = load_model(model, "intrinsic" if method == "intrinsic" else "pca")
    fit = _fitter(method, shape_model, prior_weight)
    jobs = [(path, out or out_dir / f"{path.stem}.obj") for path in landmarks]
    if len({target for _, target in jobs}) < len(jobs):
        raise click.UsageError("Two LANDMARKS have the same name; their results would replace each other.")
    inputs, failures = (*landmarks, model), []
    with progress_bar("faces") as report:
        for number, (path, target) in enumerate(jobs):
            try:
                picture = image if out is not None else _picture_beside(image, path)
                summary = _reconstruct(
                    path, target, picture, fit, shape_model, method, prior_weight, pts_origin, overwrite, inputs
                )
                click.echo(f"{target}: {summary}")
            except CaricliError as error:
                if len(jobs) == 1:
                    raise
                failures.append((path, error))
            report(number + 1, len(jobs))
    for path, error in failures:
        click.echo(f"caricli: failed: {path}: {error}", err=True)
    if failures:
        click.echo(f"caricli: {len(failures)} of {len(jobs)} failed", err=True)
        ctx.exit(1)


def _fitter(method, model, prior_weight):
    from caricli.methods.fit_landmarks import (
        IntrinsicSettings,
        LatentSettings,
        fit_landmarks_intrinsic,
        fit_landmarks_latent,
    )

    if method == "latent":
        settings = LatentSettings()
        settings = LatentSettings(noise=settings.noise * prior_weight**0.5)
        return lambda points: (fit_landmarks_latent(points, model, settings), settings)
    if model.kind != "intrinsic":
        raise InputError(f"--method intrinsic needs an intrinsic model, found one of kind {model.kind!r}")
    model.prepare()
    settings = IntrinsicSettings()
    settings = IntrinsicSettings(shrink=settings.shrink * prior_weight)
    return lambda points: (fit_landmarks_intrinsic(points, model, settings), settings)


def _reconstruct(path, target, image, fit, model, method, prior_weight, pts_origin, overwrite, inputs):
    from caricli.commands.loading import template_mesh
    from caricli.render.fit_sheet import fit_sheet

    paths = [target.with_suffix(suffix) for suffix in SUFFIXES]
    with staged(*paths, overwrite=overwrite, inputs=(*inputs, image)) as (obj_file, npz_file, json_file, png_file):
        marks = read_landmarks(path, pts_origin)
        picture = None if image is None else _picture(image, marks, path)
        start = time.perf_counter()
        result, settings = fit(marks.points)
        seconds = time.perf_counter() - start
        template, pose = model.template, result.pose
        camera = (pose.scale, pose.rotation, pose.translation)
        write_obj(obj_file, template_mesh(template, result.vertices))
        face = Face(
            result.vertices, template.faces, result.latent, result.residual, *camera, result.landmarks, model.model_id,
            template.polygons, template.uvs, template.uv_polygons,
        )  # fmt: skip
        write_face(npz_file, face)
        sheet = fit_sheet(
            result.vertices, template.faces, template.annotation, marks.points, result.landmarks, camera, picture
        )
        write_png(png_file, sheet)
        write_json(json_file, _description(path, image, method, prior_weight, settings, model, result, seconds))
    return (
        f"NME {result.nme:.2f} %, prior {result.prior_rms:.2f}, flipped {100 * result.flipped:.2f} %, {seconds:.2f} s"
    )


def _description(path, image, method, prior_weight, settings, model, result, seconds):
    known = {"method": method, "prior_weight": prior_weight, "settings": asdict(settings), "model_id": model.model_id}
    pose = {
        "scale": result.pose.scale,
        "rotation": result.pose.rotation,
        "translation": result.pose.translation,
        "convention": "pixels = scale * rotation[:2] @ vertex + translation; x right, y down, z into the picture",
    }
    return provenance("reconstruct-from-landmarks", [path, image], **known) | {
        "nme": result.nme,
        "nme_latent": result.nme_latent,
        "part_errors": result.part_errors,
        "prior_rms": result.prior_rms,
        "flipped": result.flipped,
        "pose": pose,
        "anchors": np.asarray(result.anchors),
        "iterations": result.rounds,
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
    found = [folder / f"{path.stem}{suffix}" for suffix in PICTURES if (folder / f"{path.stem}{suffix}").is_file()]
    if not found:
        raise InputError(f"{folder}: expected a picture named {path.stem} with one of {', '.join(PICTURES)}")
    return found[0]
