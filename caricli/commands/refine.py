"""caricli refine: a face aligned exactly with its picture."""

import time

import click

from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    face_files,
    image_option,
    model_option,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@click.argument("face", type=PATH)
@click.argument("landmarks", type=PATH)
@out_option("REFINED.obj", "The face; REFINED.npz, .json and .png are written beside it.", suffix=".obj")
@image_option
@click.option("--parsing", type=PATH, metavar="MASK.png", help="Labels of pixels; eye landmarks snap to the eyes.")
@click.option(
    "--weight",
    type=FiniteRange(1e-4, 1e4),
    default=1.0,
    metavar="W",
    help="Of landmarks against the shape of the surface; larger is more exact.",
)
@click.option(
    "--laplacian",
    type=click.Choice(["cotangent", "uniform"]),
    default="cotangent",
    help="How neighbours count: by the angles between them, or all the same, as published.",
)
@model_option
@subdivide_option
@overwrite_option
def command(face, landmarks, out, image, parsing, weight, laplacian, model, levels, overwrite):
    """Move a face (NPZ with a camera) exactly onto the landmarks of its picture by Laplacian deformation.

    Depth and local shape stay as they are. In the picture that is written, green circles are the given landmarks and
    red dots the fitted ones.

    \b
    Example:
      caricli refine face.npz landmarks.json --image drawing.png --out refined.obj
      caricli refine face.npz landmarks.json --parsing labels.png --out refined.obj
    """
    from caricli.commands.refined import snap_to_parsing, write_refined
    from caricli.methods.reconstruct.refine_face import refine_face
    from caricli.store.faces import load_seen_face
    from caricli.store.pictures import read_picture
    from caricli.template.fine_mesh import fine_mesh

    files = face_files(out)
    with staged(*files, overwrite=overwrite, inputs=(face, landmarks, image, parsing, model)) as temporary:
        seen, shape_model, pose = load_seen_face(face, model)
        marks = read_landmarks(landmarks)
        pixels = None if image is None else read_picture(image, marks, landmarks)
        points, snapped = snap_to_parsing(marks, parsing, pixels)
        start = time.perf_counter()
        try:
            found = refine_face(seen.vertices, pose, points, shape_model.template, weight, laplacian)
        except InputError as error:
            raise InputError(f"{landmarks}: {error}") from error
        seconds = time.perf_counter() - start
        fine = fine_mesh(shape_model.template, levels)
        sheet = write_refined(temporary, found, seen, shape_model, pose, points, pixels, fine)
        about = {"weight": weight, "laplacian": laplacian, "snapped": snapped, "subdivide": levels, "seconds": seconds}
        about |= {"before": found.before, "after": found.after, "moved": found.moved, "flipped": found.flipped}
        inputs = [face, landmarks, image, parsing]
        write_json(temporary[2], provenance("refine", inputs, model_id=shape_model.model_id, **about))
        write_png(temporary[3], sheet)
    figures = f"NME {found.before['all']:.2f} to {found.after['all']:.3f} %, flipped {100 * found.flipped:.3f} %"
    click.echo(f"{out}: {figures}, moved at most {1000 * found.moved:.1f} mm, {seconds:.2f} s")
