"""caricli fit-coarse: a picture to a face of the morphable model, by a network."""

from dataclasses import replace

import click

from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
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


@click.command()
@click.argument("pictures", nargs=-1, required=True, type=PATH, metavar="PICTURE|LANDMARKS...")
@out_option("FACE.obj", f"Write the face of one input here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many inputs into this folder, each under the name of its input.")
@image_option
@click.option(
    "--network", type=PATH, metavar="FILE", help="Use this network of `caricli train coarse`.  [default: caricli's]"
)
@click.option("--alone", is_flag=True, help="Take the network's word for the shape, and do not bring it to landmarks.")
@model_option
@detector_option
@pts_origin_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
@click.pass_context
def command(ctx, pictures, out, out_dir, image, network, alone, model, detector, pts_origin, head, levels, overwrite):
    """Let a network tell identity, expression, colours, light and pose of the face in a picture.

    The morphable model's face, as `fit-morphable` gives it, but from all that the picture shows. It is then brought
    nearer to the landmarks as far as the network is usually wrong. All numbers are in FACE.json. The landmarks of a
    PICTURE are found, and written beside the result; LANDMARKS that are given need their picture by --image.

    \b
    Example:
      caricli fit-coarse photo.jpg --out face.obj
      caricli fit-coarse landmarks.json --image drawing.png --out face.obj
    """
    from caricli.commands.shared.batch import run_batch
    from caricli.commands.shared.fit_tasks import network_task
    from caricli.commands.shared.landmark_batch import LandmarkFiles
    from caricli.store.face_pictures import FaceReader

    refuse_unread(pictures, image)
    files = LandmarkFiles(pictures, out, out_dir, image, FaceReader(detector, pts_origin), overwrite)
    task = replace(network_task(files, model, network, alone), levels=levels, head=head)
    run_batch(ctx, files.jobs(), task.run, "faces")
