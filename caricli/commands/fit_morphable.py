"""caricli fit-morphable: 2D landmarks to a face of the morphable model."""

from dataclasses import astuple

import click

from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    image_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    subdivide_option,
)
from caricli.methods.reconstruct.settings import MorphableWeights


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
    default=astuple(MorphableWeights()),
    metavar="ID EXP",
    help="Regularisation of identity and expression: larger stays nearer to the mean, smaller nearer to the landmarks.",
)
@pts_origin_option
@subdivide_option
@overwrite_option
def command(landmarks, out, out_dir, image, model, expression_only, identity, weights, pts_origin, levels, overwrite):
    """Fit identity, expression and pose of a morphable model to 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    The face is regular: `reconstruct-from-landmarks` follows a caricature more closely. With several LANDMARKS --image
    is a folder of pictures with the same names.

    \b
    Example:
      caricli fit-morphable landmarks.json --image drawing.png --out face.obj
      caricli fit-morphable smile.json --expression-only --identity face.npz --out smile.obj
    """
    from caricli.commands.shared.landmark_batch import FitTask, LandmarkFiles, fit_all
    from caricli.methods.reconstruct.fit_morphable import fit_morphable
    from caricli.store.faces import load_identity
    from caricli.store.models import load_morphable
    from caricli.template.fine_mesh import fine_mesh

    if identity is not None and not expression_only:
        raise click.UsageError("--identity needs --expression-only.")
    files = LandmarkFiles(landmarks, out, out_dir, image, pts_origin, overwrite)
    shape_model = load_morphable(model)
    kept, note = load_identity(identity, shape_model) if expression_only else (None, None)
    if note:
        click.echo(note, err=True)

    def fit(points):
        return fit_morphable(points, shape_model, MorphableWeights(*weights), kept)

    def say(fit):
        return f"NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}"

    about = {"model_id": shape_model.model_id, "weights": weights, "expression_only": expression_only}
    about["subdivide"] = levels
    fine = fine_mesh(shape_model.template, levels)
    fit_all(files, FitTask("fit-morphable", shape_model, fine, fit, say, about, [identity]), model)
