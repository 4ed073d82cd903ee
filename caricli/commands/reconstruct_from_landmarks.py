"""caricli reconstruct-from-landmarks: a picture, or 2D landmarks, to a 3D caricature."""

from dataclasses import replace

import click

from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    detector_option,
    image_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_unread,
    subdivide_option,
)
from caricli.commands.shared.picture import picture_option
from caricli.errors import UsageError
from caricli.methods.reconstruct.settings import METHODS


@click.command()
@click.argument("landmarks", nargs=-1, required=True, type=PATH, metavar="PICTURE|LANDMARKS...")
@out_option("FACE.obj", f"Write the face of one input here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many inputs into this folder, each under the name of its input.")
@image_option
@click.option(
    "--parsing",
    type=PATH,
    metavar="LABELS.png",
    help="Look for ears by this label map of --image, as `caricli detect` writes it.  [default: seen by the detector]",
)
@click.option(
    "--method",
    type=click.Choice(METHODS),
    help="Let the surface follow the landmarks elastically (intrinsic), or stay inside the model (latent).  "
    "[default: intrinsic, where the model is of that kind]",
)
@model_option
@click.option(
    "--prior-weight",
    type=FiniteRange(0.01, 100),
    default=1.0,
    metavar="W",
    help="Stay nearer to plausible faces (larger) or nearer to the landmarks (smaller).",
)
@click.option(
    "--outline",
    type=click.Choice(["auto", "none"]),
    default="auto",
    help="Find in the picture ears and forehead, which pull weakly, where 68 landmarks come with --image, ears beside "
    "detected landmarks, the outline of ears, and a thin neck (auto); or leave them as such a face has them (none).",
)
@detector_option
@pts_origin_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
@click.pass_context
def command(
    ctx,
    landmarks,
    out,
    out_dir,
    image,
    parsing,
    method,
    model,
    prior_weight,
    outline,
    detector,
    pts_origin,
    head,
    levels,
    overwrite,
):
    """Reconstruct 3D caricatures from pictures, or from 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    In a PICTURE the largest face is found, and its landmarks are written beside the result, FACE-landmarks.json, to be
    corrected and given in its place with --image. With several LANDMARKS --image is a folder of pictures with the same
    names. In the picture that is written, green circles are the given landmarks and what was found in the picture
    besides; red dots are the fitted landmarks.

    \b
    Example:
      caricli reconstruct-from-landmarks drawing.png --out face.obj
      caricli reconstruct-from-landmarks landmarks.json --image drawing.png --out face.obj
      caricli reconstruct-from-landmarks marks/*.txt --image drawings --out-dir faces
    """
    from caricli.commands.shared.batch import run_batch
    from caricli.commands.shared.fit_tasks import elastic_task
    from caricli.commands.shared.landmark_batch import LandmarkFiles
    from caricli.store.face_pictures import FaceReader

    if parsing and outline == "none":
        raise UsageError("--parsing says where ears are, and --outline none looks for none: give one of them")
    refuse_unread(landmarks, image)
    files = LandmarkFiles(landmarks, out, out_dir, image, FaceReader(detector, pts_origin), overwrite, parsing)
    task = replace(elastic_task(files, model, method, prior_weight, outline), levels=levels, head=head)
    run_batch(ctx, files.jobs(), task.run, "faces")
