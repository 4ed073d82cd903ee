"""caricli caricaturize: regular faces made caricatures."""

from dataclasses import asdict

import click
import numpy as np

from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    directions_option,
    face_files,
    image_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.structures import Face

SIZE, DRAWN = 320, (0.0, 0.5, 1.0)


@click.command()
@click.argument("faces", nargs=-1, required=True, type=PATH, metavar="FACE...")
@click.option(
    "--strength",
    type=FiniteRange(0, 10),
    default=1.0,
    metavar="S",
    help="0 changes nothing, 1 shows clearly, 2 is strong.",
)
@click.option(
    "--mode",
    type=click.Choice(["direction", "own"]),
    default="direction",
    help="Towards what caricatures have in common, or away from the mean head.",
)
@out_option("FACE.obj", "The result of one input; FACE.npz, .json and .png are written beside it.", required=False)
@out_folder_option("The results of many inputs, each under the name of its file.")
@click.option("--from-landmarks", "marked", is_flag=True, help="FACE is a landmark file; reconstruct it first.")
@image_option
@directions_option
@model_option
@subdivide_option
@overwrite_option
@click.pass_context
def command(ctx, faces, strength, mode, out, out_dir, marked, image, directions, model, levels, overwrite):
    """Exaggerate faces (OBJ or NPZ), or with --from-landmarks the faces that landmarks belong to.

    The direction goes from regular faces to caricatures, the same way for all; a face's own way enlarges whatever sets
    it apart. The picture shows strengths up to the one asked for.

    \b
    Example:
      caricli caricaturize face.npz --strength 2 --out caricature.obj
      caricli caricaturize faces/*.npz --mode own --out-dir caricatures
      caricli caricaturize landmarks.json --from-landmarks --image photo.jpg --out caricature.obj
    """
    from caricli.commands.series import write_series_face
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.methods.edit.caricaturize_face import caricaturize_face
    from caricli.methods.faces.nearest_identity import likeness
    from caricli.store.directions import directions_path, load_directions
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.store.pictures import picture_beside
    from caricli.template.fine_mesh import fine_mesh

    if image and not marked:
        raise click.UsageError("--image goes with --from-landmarks.")
    jobs = named_jobs(faces, "LANDMARKS" if marked else "FACE", out, out_dir, ".obj")
    shape_model = load_model(model, DEFAULT_LATENT)
    # A face's own way needs no directions, so it works for models that have none.
    path = directions_path(directions, shape_model) if directions or mode == "direction" else None
    known, fine = path and load_directions(path, shape_model), fine_mesh(shape_model.template, levels)
    load = _landmark_loader(shape_model) if marked else _face_loader(shape_model, model is None)

    def caricaturize(source, target):
        picture = image if out is not None else picture_beside(image, source)
        files = face_files(target)
        with staged(*files, overwrite=overwrite, inputs=(*faces, model, path, picture)) as temporary:
            regular, seen, portrait, note = load(source, picture)
            degrees = [caricaturize_face(regular, shape_model, strength * part, mode, known) for part in DRAWN]
            write_series_face(temporary[:2], degrees[-1], shape_model, fine, seen)
            ends = zip(("before", "after"), (regular, degrees[-1]), strict=True)
            figures = {when: _figures(face, shape_model, known) for when, face in ends}
            match = known and likeness(regular, degrees[-1], shape_model, known.people)
            about = {"model_id": shape_model.model_id, "mode": mode, "strength": strength, "subdivide": levels}
            about["identity"] = match and asdict(match)
            write_json(temporary[2], provenance("caricaturize", [source, picture, path], **about, **figures))
            write_png(temporary[3], _sheet(degrees, strength, portrait, shape_model, fine))
        if note:
            click.echo(note, err=True)
        return f"{target}: {_summary(figures)}"

    run_batch(ctx, jobs, caricaturize, "faces")


def _face_loader(model, anew):
    """A function: path to EncodedFace, Face, no picture, and what is to be said."""
    from caricli.store.faces import load_latent_face

    def load(path, _):
        face, source, note = load_latent_face(path, model, anew)
        return face, source, None, note

    return load


def _landmark_loader(model):
    """The same for landmark files, fitted as `caricli reconstruct-from-landmarks` does; with a portrait."""
    from caricli.methods.faces.encode_face import encode_face
    from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
    from caricli.store.models import load_model
    from caricli.store.pictures import read_picture

    elastic = model if model.kind == "intrinsic" else load_model()
    # The elastic fit is the better one; on another mesh than the bundled models' only the latent one is left.
    same = elastic.template.topology_id == model.template.topology_id
    fitter, method = (elastic, "intrinsic") if same else (model, "latent")
    fitter.prepare()

    def load(path, picture):
        marks = read_landmarks(path)
        pixels = None if picture is None else read_picture(picture, marks, path)
        fit = fit_landmarks(marks.points, fitter, method)
        own = (fit.latent, fit.residual) if fitter is model else ()
        seen = Face(model.template.with_vertices(fit.vertices), fit.pose, fit.landmarks)
        portrait = None if pixels is None else _portrait(pixels, marks.points)
        return encode_face(fit.vertices, model, *own), seen, portrait, f"{path}: reconstructed, NME {fit.nme:.2f} %"

    return load


def _figures(face, model, directions):
    """What the JSON says of a face."""
    from caricli.methods.edit.caricaturize_face import exaggeration
    from caricli.methods.edit.face_figures import face_figures

    return {"exaggeration": asdict(exaggeration(face, model, directions))} | face_figures(face, model)


def _summary(figures):
    """The line to print: how far from the mean head, how plausible, how sound."""
    before, after = (figures[when]["exaggeration"]["distance"] for when in ("before", "after"))
    prior, flipped = figures["after"]["prior_rms"], 100 * figures["after"]["flipped"]
    return f"distance {before:.3f} to {after:.3f}, prior {prior:.2f}, flipped triangles {flipped:.3f} %"


def _sheet(faces, strength, portrait, model, fine):
    """The faces in a row, each from two sides, after the picture where there is one."""
    from caricli.commands.series import draw_series_face
    from caricli.methods.faces.subdivide_face import subdivide_face
    from caricli.render.contact_sheet import contact_sheet

    pictures, labels = ([], []) if portrait is None else ([portrait], ["given"])
    for face, part in zip(faces, DRAWN, strict=True):
        finer = subdivide_face(face.vertices, face.latent, model, fine)
        pictures.append(np.vstack(draw_series_face(face, finer, model, fine, SIZE)))
        labels.append(f"{strength * part:g}")
    return contact_sheet(pictures, len(pictures), labels)


def _portrait(image, points):
    """The square of a picture (H, W, 3) around landmarks (L, 2), SIZE pixels wide."""
    from PIL import Image

    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    half = 0.8 * (high - low).max()
    box = (*((low + high) / 2 - half), *((low + high) / 2 + half))
    return np.asarray(
        Image.fromarray(image).transform((SIZE, SIZE), Image.Transform.EXTENT, box, Image.Resampling.BICUBIC)
    )
