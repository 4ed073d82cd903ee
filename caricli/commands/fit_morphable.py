"""caricli fit-morphable: 2D landmarks to a face of the morphable model."""

import time

import click
import numpy as np

from caricli.commands.shared.options import (
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
from caricli.errors import InputError
from caricli.io.landmarks import read_landmarks
from caricli.io.outputs import staged
from caricli.io.provenance import provenance


@click.command()
@click.argument("landmarks", nargs=-1, required=True, type=PATH, metavar="LANDMARKS...")
@out_option("FACE.obj", "The result of one input; FACE.npz, .json and .png are written beside it.", required=False)
@out_folder_option("The results of many inputs, each under the name of its file.")
@image_option
@model_option
@click.option("--expression-only", is_flag=True, help="Keep the identity: the mean, or that of --identity.")
@click.option("--identity", type=PATH, metavar="FACE", help="With --expression-only: whose identity it is.")
@click.option(
    "--weight",
    "weights",
    nargs=2,
    type=FiniteRange(0.001, 1000),
    default=(1.2, 1.0),
    metavar="ID EXP",
    help="Regularisation of identity and expression: larger stays nearer to the mean, smaller nearer to the landmarks.",
)
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@subdivide_option
@overwrite_option
@click.pass_context
def command(
    ctx, landmarks, out, out_dir, image, model, expression_only, identity, weights, pts_origin, levels, overwrite
):
    """Fit identity, expression and pose of a morphable model to 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    The face is regular: `reconstruct-from-landmarks` follows a caricature more closely. With several LANDMARKS --image
    is a folder of pictures with the same names.

    \b
    Example:
      caricli fit-morphable landmarks.json --image drawing.png --out face.obj
      caricli fit-morphable smile.json --expression-only --identity face.npz --out smile.obj
    """
    from caricli.commands.fitted import fit_figures, write_fit
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.methods.reconstruct.fit_morphable import fit_morphable
    from caricli.store.faces import load_latent_face
    from caricli.store.models import load_model
    from caricli.store.pictures import picture_beside, read_picture
    from caricli.template.fine_mesh import fine_mesh

    if identity is not None and not expression_only:
        raise click.UsageError("--identity needs --expression-only.")
    jobs = named_jobs(landmarks, "LANDMARKS", out, out_dir, ".obj")
    shape_model = load_model(model, "morphable")
    if shape_model.kind != "morphable":
        raise InputError(f"{model}: expected a model of kind morphable, found {shape_model.kind}")
    fine = fine_mesh(shape_model.template, levels)
    kept, note = np.zeros(len(shape_model.identity)) if expression_only else None, None
    if identity is not None:
        code, _, note = load_latent_face(identity, shape_model, anew=True)
        kept = shape_model.parts(code.latent)[0]
    if note:
        click.echo(note, err=True)
    known = {"weights": weights, "expression_only": expression_only, "subdivide": levels}

    def reconstruct(path, target):
        picture = image if out is not None else picture_beside(image, path)
        paths = face_files(target)
        with staged(*paths, overwrite=overwrite, inputs=(*landmarks, model, identity, picture)) as files:
            marks = read_landmarks(path, pts_origin)
            pixels = None if picture is None else read_picture(picture, marks, path)
            start = time.perf_counter()
            fit = fit_morphable(marks.points, shape_model, weights, kept)
            seconds = time.perf_counter() - start
            inputs = [path, picture, identity]
            description = provenance("fit-morphable", inputs, model_id=shape_model.model_id, **known) | fit_figures(
                fit, seconds
            )
            write_fit(files, shape_model, fit, fine, marks.points, pixels, description)
        return f"{target}: NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}, {seconds:.2f} s"

    run_batch(ctx, jobs, reconstruct, "faces")
