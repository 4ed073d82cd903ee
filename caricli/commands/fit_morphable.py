"""caricli fit-morphable: a picture, or 2D landmarks, to a face of the morphable model."""

from dataclasses import astuple, replace

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
from caricli.methods.reconstruct.settings import MorphableWeights


@click.command()
@click.argument("landmarks", nargs=-1, required=True, type=PATH, metavar="PICTURE|LANDMARKS...")
@out_option("FACE.obj", f"Write the face of one input here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many inputs into this folder, each under the name of its input.")
@image_option
@model_option
@click.option("--expression-only", is_flag=True, help="Fit the expression alone, of the mean face or of --identity.")
@click.option("--identity", type=PATH, metavar="FACE", help="Keep the identity of this face, with --expression-only.")
@click.option(
    "--weight",
    "weights",
    nargs=2,
    type=FiniteRange(0.001, 1000),
    default=astuple(MorphableWeights()),
    metavar="ID EXP",
    help="Hold identity and expression nearer to the mean face (larger) or to the landmarks (smaller).",
)
@click.option(
    "--photometric", is_flag=True, help="Fit the colours of the picture, too: those of the skin, and the light on it."
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
    model,
    expression_only,
    identity,
    weights,
    photometric,
    detector,
    pts_origin,
    head,
    levels,
    overwrite,
):
    """Fit a morphable model to the face of a picture, or to 68 (iBUG) or 81 landmarks: JSON, .pts, text or NPY.

    Identity, expression and pose are fitted. The face is regular: `reconstruct-from-landmarks` follows a caricature
    more closely. The landmarks of a PICTURE are found, and written beside the result, FACE-landmarks.json. With several
    LANDMARKS --image is a folder of pictures with the same names. With --photometric the shape also follows the shading
    of the skin, and the face wears its colours without the light.

    \b
    Example:
      caricli fit-morphable photo.jpg --out face.obj
      caricli fit-morphable photo.jpg --photometric --out face.glb
      caricli fit-morphable landmarks.json --image drawing.png --out face.obj
      caricli fit-morphable smile.json --expression-only --identity face.npz --out smile.obj
    """
    from caricli.commands.shared.batch import run_batch
    from caricli.commands.shared.fit_tasks import morphable_task
    from caricli.commands.shared.landmark_batch import LandmarkFiles
    from caricli.store.face_pictures import FaceReader

    if identity is not None and not expression_only:
        raise click.UsageError("--identity needs --expression-only.")
    refuse_unread(landmarks, image)
    files = LandmarkFiles(landmarks, out, out_dir, image, FaceReader(detector, pts_origin), overwrite)
    task = morphable_task(files, model, MorphableWeights(*weights), expression_only, identity, photometric)
    run_batch(ctx, files.jobs(), replace(task, levels=levels, head=head).run, "faces")
