"""caricli edit-semantic: more or less of what labels name."""

import click
import numpy as np

from caricli.commands.shared.options import (
    PATH,
    directions_option,
    face_files,
    model_option,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE = 320


@click.command()
@click.argument("face", required=False, type=PATH)
@click.option("--label", "labels", multiple=True, metavar="NAME=S", help="How far to go towards a label; repeat.")
@out_option("EDITED.obj", "The face; EDITED.npz, .json and .png are written beside it.", False, ".obj")
@click.option("--keep", multiple=True, metavar="NAME", help="A label that is not to change; repeat for more.")
@click.option("--steps", type=click.IntRange(2, 25), metavar="N", help="Draw N faces from minus to plus the strengths.")
@click.option("--list", "listed", is_flag=True, help="Print the labels, how well they are known, and stop.")
@directions_option
@model_option
@subdivide_option
@overwrite_option
def command(face, labels, out, keep, steps, listed, directions, model, levels, overwrite):
    """Give a face (OBJ or NPZ) more of a label, or less with a negative strength, in standard deviations of faces.

    What the latent cannot express stays on the face, so the opposite strength takes it back. A face without a latent is
    encoded first. The picture shows the face before and after, or with --steps a film strip.

    \b
    Example:
      caricli edit-semantic --list
      caricli edit-semantic face.npz --label BigNose=2 --label Smile=-1 --out edited.obj
      caricli edit-semantic face.npz --label BigNose=3 --keep BigMouth --steps 5 --out strip.obj
    """
    from caricli.commands.series import write_series_face
    from caricli.commands.shared.tables import print_directions
    from caricli.methods.edit.edit_semantic import edit_semantic
    from caricli.methods.edit.face_figures import face_figures
    from caricli.store.directions import directions_path, load_directions
    from caricli.store.faces import load_latent_face
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.template.fine_mesh import fine_mesh

    shape_model = load_model(model, DEFAULT_LATENT)
    path = directions_path(directions, shape_model)
    known = load_directions(path, shape_model)
    if listed:
        return print_directions(known)
    if face is None or out is None or not labels:
        raise click.UsageError("Give a FACE, at least one --label and --out; or --list.")
    strengths, fine = _strengths(labels), fine_mesh(shape_model.template, levels)
    files = face_files(out)
    with staged(*files, overwrite=overwrite, inputs=(face, model, path)) as (obj_file, npz_file, json_file, png_file):
        before, source, note = load_latent_face(face, shape_model, anew=model is None)
        after = edit_semantic(before, shape_model, known, strengths, keep)
        write_series_face((obj_file, npz_file), after, shape_model, fine, source)
        figures = {name: face_figures(each, shape_model) for name, each in (("before", before), ("after", after))}
        about = {"model_id": shape_model.model_id, "labels": strengths, "keep": keep, "subdivide": levels}
        write_json(json_file, provenance("edit-semantic", [face, path], **about, **figures))
        write_png(png_file, _strip(before, shape_model, known, strengths, keep, steps, fine))
    if note:
        click.echo(note, err=True)
    prior, flipped = figures["after"]["prior_rms"], 100 * figures["after"]["flipped"]
    click.echo(f"{out}: {' '.join(labels)}, prior {prior:.2f}, flipped triangles {flipped:.3f} %")


def _strengths(labels):
    """A dict of names to strengths."""
    strengths = {}
    for text in labels:
        name, equals, value = text.partition("=")
        try:
            strengths[name] = float(value)
        except ValueError:
            raise InputError(f"--label {text}: expected NAME=STRENGTH, such as BigNose=2") from None
    if len(strengths) < len(labels):
        raise InputError(f"--label: expected every label once, found {' '.join(labels)}")
    return strengths


def _strip(face, model, directions, strengths, keep, steps, fine):
    """The face before beside after, or in steps from minus to plus the strengths."""
    from caricli.commands.series import draw_series_face
    from caricli.methods.edit.edit_semantic import edit_semantic
    from caricli.methods.faces.subdivide_face import subdivide_face
    from caricli.render.contact_sheet import contact_sheet

    parts = np.linspace(-1, 1, steps) if steps else (0.0, 1.0)
    pictures = []
    for part in parts:
        edited = edit_semantic(face, model, directions, {n: part * s for n, s in strengths.items()}, keep)
        finer = subdivide_face(edited.vertices, edited.latent, model, fine)
        pictures.append(np.vstack(draw_series_face(edited, finer, model, fine, SIZE)))
    first = len(strengths) == 1 and next(iter(strengths.values()))
    names = [f"{part * first:+.3g}" if first else f"{100 * part:+.0f} %" for part in parts]
    return contact_sheet(pictures, len(pictures), names if steps else ("before", "after"))
