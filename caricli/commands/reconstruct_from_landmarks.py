"""caricli reconstruct-from-landmarks: 2D landmarks to a 3D caricature."""

import time

import click

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
from caricli.io.landmarks import read_landmarks
from caricli.io.outputs import staged
from caricli.io.provenance import provenance


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
    from caricli.commands.fitted import fit_figures, write_fit
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.store.pictures import picture_beside, read_picture
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
            description = provenance("reconstruct-from-landmarks", [path, picture], **known) | fit_figures(fit, seconds)
            write_fit(files, shape_model, fit, fine, marks.points, pixels, description)
        quality = f"NME {fit.nme:.2f} %, prior {fit.prior_rms:.2f}, flipped {100 * fit.flipped:.2f} %"
        return f"{target}: {quality}, {seconds:.2f} s"

    run_batch(ctx, jobs, reconstruct, "faces")
