"""caricli edit-handle: points that are pulled, and a face that follows."""

import time

import click
import numpy as np

from caricli.commands.shared.options import (
    PATH,
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
from caricli.io.strict_json import read_json, write_json

SIZE = 320


@click.command()
@click.argument("face", type=PATH, metavar="FACE")
@click.option(
    "--handle", "handles", multiple=True, metavar="WHERE=DX,DY,DZ",
    help="Move a point: a vertex index, a landmark such as l30, or a name such as nose_tip, by metres or by 5% of the "
    "head's height. Repeat for more.",
)  # fmt: skip
@click.option("--handles", "file", type=PATH, metavar="JSON", help='More of them: {"nose_tip": [0, 0, "5%"], ...}.')
@click.option("--pin", "pins", multiple=True, metavar="WHERE", help="Hold a point where it is. Repeat for more.")
@click.option("--symmetric", is_flag=True, help="Do the same on the other side of the face.")
@out_option("EDITED.obj", "The face; EDITED.npz, .json and .png are written beside it.", suffix=".obj")
@click.option("--norm", type=click.Choice(["l2", "l1"]), default="l2", help="Of the latent's change; l1 as published.")
@click.option("--no-intersections", "avoid", is_flag=True, help="Go only as far as the surface does not cross itself.")
@click.option("--steps", type=click.IntRange(2, 25), metavar="N", help="Draw a film strip of N faces.")
@click.option("--baseline", type=click.Choice(["arap"]), help="Draw as-rigid-as-possible deformation beside it.")
@model_option
@subdivide_option
@overwrite_option
def command(face, handles, file, pins, symmetric, out, norm, avoid, steps, baseline, model, levels, overwrite):
    """Pull points of a face (OBJ or NPZ) and let the rest follow as faces do.

    What the latent cannot express stays on the face. A face without a latent is encoded first, one of another bundled
    model anew. Left and right are the subject's; +x is the subject's left, +y up, +z out of the face. The picture shows
    the face before and after, or with --steps a film strip.

    \b
    Example:
      caricli edit-handle face.npz --handle nose_tip=0,0,5% --out nose.obj
      caricli edit-handle face.npz --handle ear_left=5%,0,0 --symmetric --pin chin --steps 5 --out ears.obj
    """
    from caricli.commands.series import write_series_face
    from caricli.geometry.self_intersections import self_intersections
    from caricli.methods.edit.edit_handles import HandleSettings, edit_handles
    from caricli.methods.edit.handle_points import handle_points
    from caricli.store.faces import load_latent_face
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.template.fine_mesh import fine_mesh

    shape_model = load_model(model, DEFAULT_LATENT)
    fine, files = fine_mesh(shape_model.template, levels), face_files(out)
    settings = HandleSettings(norm=1 if norm == "l1" else 2)
    with staged(*files, overwrite=overwrite, inputs=(face, file, model)) as (obj_file, npz_file, json_file, png_file):
        points = handle_points(_asked(handles, file), pins, shape_model.template, symmetric)
        before, source, note = load_latent_face(face, shape_model, anew=model is None)
        start = time.perf_counter()
        edit = edit_handles(before, shape_model, *points[:2], settings, avoid)
        seconds = time.perf_counter() - start
        crossing = [len(self_intersections(f.vertices, shape_model.template.faces)) for f in (before, edit.face)]
        write_series_face((obj_file, npz_file), edit.face, shape_model, fine, source)
        about = {"model_id": shape_model.model_id, "norm": norm, "subdivide": levels, "seconds": seconds}
        write_json(json_file, provenance("edit-handle", [face, file], **about, **_figures(edit, points, crossing)))
        drawn = [points[0], edit.share * points[1], settings]
        write_png(png_file, _picture(before, edit, drawn, shape_model, fine, steps, baseline))
    if note:
        click.echo(note, err=True)
    click.echo(f"{out}: {_said(edit, points, crossing)}, {seconds:.2f} s")


def _asked(handles, file):
    """Pairs of a place and three lengths, of the options and of the file."""
    asked = []
    for text in handles:
        where, equals, lengths = text.partition("=")
        if not equals:
            raise InputError(f"--handle {text[:60]}: expected WHERE=DX,DY,DZ, such as nose_tip=0,0,5%")
        asked.append((where, lengths.split(",")))
    if file is not None:
        known = read_json(file)
        if not isinstance(known, dict):
            raise InputError(f"{file}: expected a JSON object of places to three lengths, found {type(known).__name__}")
        asked += known.items()
    return asked


def _reached(edit, displacements):
    """(H,) share of every displacement that was reached, along it; nan for what was to stay."""
    squares = (displacements**2).sum(1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(squares > 0, (edit.achieved * displacements).sum(1) / squares, np.nan)


def _figures(edit, points, crossing):
    """What the JSON says of an edit."""
    rows = [
        {"where": name, "vertex": int(vertex), "requested": asked, "achieved": achieved}
        | ({} if np.isnan(reached) else {"reached": float(reached)})
        for name, vertex, asked, achieved, reached in zip(
            points[2], points[0], points[1], edit.achieved, _reached(edit, points[1]), strict=True
        )
    ]
    counts = {"flipped_triangles": edit.flipped, "crossing_pairs": crossing}
    return {
        "handles": rows,
        "share": edit.share,
        "energy_elsewhere": edit.elsewhere,
        "prior_rms": edit.face.prior_rms,
        **{name: {"before": before, "after": after} for name, (before, after) in counts.items()},
    }


def _said(edit, points, crossing):
    reached = 100 * np.nanmin(_reached(edit, points[1]))
    added = edit.flipped[1] - edit.flipped[0], crossing[1] - crossing[0]
    shortened = "" if edit.share == 1 else f", shortened to {100 * edit.share:.0f} %"
    return f"reached {reached:.0f} %{shortened}, flipped triangles {added[0]:+d}, crossing pairs {added[1]:+d}"


def _picture(before, edit, drawn, model, fine, steps, baseline):
    """The face before and after in three views, with the baseline below; or a film strip."""
    from caricli.methods.edit.deform_arap import deform_arap
    from caricli.methods.edit.edit_handles import edit_handles
    from caricli.methods.faces.subdivide_face import subdivide_face
    from caricli.render.contact_sheet import contact_sheet
    from caricli.render.head_views import head_views

    handles, displacements, settings = drawn
    template, views = model.template, ("front", "three-quarter") if steps else ("front", "three-quarter", "profile")

    def draw(face):
        finer = fine.with_vertices(subdivide_face(face.vertices, face.latent, model, fine))
        return head_views(template.with_vertices(face.vertices), views, SIZE, finer)

    if steps:
        parts = np.linspace(0, 1, steps)
        faces = [edit_handles(before, model, handles, part * displacements, settings).face for part in parts]
        labels = [f"{100 * part:.0f} %" for part in parts]
        return contact_sheet([np.vstack(draw(face)) for face in faces], steps, labels)
    rows, labels = [np.hstack(draw(face)) for face in (before, edit.face)], ["before", "after"]
    if baseline:
        rigid = deform_arap(before.vertices, template.faces, handles, displacements)
        rows.append(np.hstack(head_views(template.with_vertices(rigid), views, SIZE)))
        labels.append("as rigid as possible")
    return contact_sheet(rows, 1, labels)
