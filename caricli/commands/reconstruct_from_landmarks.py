"""caricli reconstruct-from-landmarks: 2D landmarks to a 3D caricature."""

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
from caricli.methods.reconstruct.settings import METHODS


@click.command()
@click.argument("landmarks", nargs=-1, required=True, type=PATH, metavar="LANDMARKS...")
@out_option("FACE.obj", "The result of one input; FACE.npz, .json and .png are written beside it.", required=False)
@out_folder_option("The results of many inputs, each under the name of its file.")
@image_option
@click.option(
    "--method",
    type=click.Choice(METHODS),
    default=METHODS[0],
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
@pts_origin_option
@subdivide_option
@overwrite_option
def command(landmarks, out, out_dir, image, method, model, prior_weight, pts_origin, levels, overwrite):
    """Reconstruct 3D caricatures from 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    With several LANDMARKS --image is a folder of pictures with the same names. In the picture that is written, green
    circles are the given landmarks and red dots the fitted ones.

    \b
    Example:
      caricli reconstruct-from-landmarks landmarks.json --image drawing.png --out face.obj
      caricli reconstruct-from-landmarks marks/*.txt --image drawings --out-dir faces
    """
    from caricli.commands.shared.landmark_batch import FitTask, LandmarkFiles, fit_all
    from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
    from caricli.store.models import DEFAULT_ELASTIC, DEFAULT_LATENT, load_model
    from caricli.template.fine_mesh import fine_mesh

    files = LandmarkFiles(landmarks, out, out_dir, image, pts_origin, overwrite)
    shape_model = load_model(model, DEFAULT_ELASTIC if method == "intrinsic" else DEFAULT_LATENT)
    shape_model.prepare()

    def fit(points):
        return fit_landmarks(points, shape_model, method, prior_weight)

    def say(fit):
        return f"NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}, flipped {100 * fit.flipped:.2f} %"

    about = {"method": method, "prior_weight": prior_weight, "model_id": shape_model.model_id, "subdivide": levels}
    fine = fine_mesh(shape_model.template, levels)
    fit_all(files, FitTask("reconstruct-from-landmarks", shape_model, fine, fit, say, about), model)
