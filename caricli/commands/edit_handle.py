"""caricli edit-handle: points that are pulled, and a face that follows."""

import time
from functools import partial

import click

from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    WholeRange,
    model_option,
    named_mesh,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.commands.shared.picture import SIZE, picture_option, refuse_undrawn
from caricli.errors import UsageError, shown
from caricli.io.provenance import provenance


@click.command()
@click.argument("face", type=PATH, metavar="FACE")
@click.option(
    "--handle", "texts", multiple=True, metavar="WHERE=DX,DY,DZ",
    help="Move a point (a vertex index, a landmark such as l30, or a name such as nose_tip) by metres, or by percent "
    "of this face's height; repeat for more.",
)  # fmt: skip
@click.option(
    "--handles",
    "file",
    type=PATH,
    metavar="JSON",
    help='Read more handles from a file such as {"nose_tip": [0, 0, "5%"]}.',
)
@click.option("--pin", "pins", multiple=True, metavar="WHERE", help="Hold a point where it is; repeat for more.")
@click.option("--symmetric", is_flag=True, help="Do the same on the other side of the face.")
@out_option("EDITED.obj", f"Write the face here, {FACE_FILES}", check=named_mesh)
@click.option(
    "--norm",
    type=click.Choice(["l2", "l1"]),
    default="l2",
    help="Change all of the latent a little, which folds less (l2), or few entries of it more, as published (l1).",
)
@click.option(
    "--no-intersections", "avoid", is_flag=True, help="Go only as far as the surface does not cross itself anew."
)
@click.option(
    "--steps", type=WholeRange(2, 25), metavar="N", help="Draw a film strip of N faces instead of before and after."
)
@click.option("--baseline", type=click.Choice(["arap"]), help="Draw as-rigid-as-possible deformation, too, to compare.")
@model_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
def command(face, texts, file, pins, symmetric, out, norm, avoid, steps, baseline, model, head, levels, overwrite):
    """Pull points of a face (NPZ, OBJ, PLY, GLB or glTF) and let the rest follow as faces do.

    What the latent cannot express stays on the face. A face without a latent is encoded first, one of another bundled
    model anew. Left and right are the subject's; +x is the subject's left, +y up, +z out of the face. The picture shows
    the face before and after, with --baseline also as-rigid-as-possible deformation, or with --steps a film strip.

    \b
    Example:
      caricli edit-handle face.npz --handle nose_tip=0,0,5% --out nose.obj
      caricli edit-handle face.npz --handle ear_left=5%,0,0 --symmetric --pin chin --steps 5 --out ears.obj
    """
    from caricli.methods.edit.edit_handles import HandleSettings, edit_handles
    from caricli.methods.edit.handle_figures import handle_figures
    from caricli.methods.edit.handle_points import handle_points
    from caricli.store.drawings import load_drawing
    from caricli.store.face_files import write_face_result
    from caricli.store.faces import load_latent_face
    from caricli.store.handles import load_handles

    asked = _asked(texts, file)
    picture = _picture(steps, baseline)
    drawing = load_drawing(model, levels, SIZE, head)
    settings = HandleSettings(norm=1 if norm == "l1" else 2)
    with staged_face(out, overwrite, (face, file, model), "pulling") as files:
        before, note = load_latent_face(face, drawing.model, anew=model is None)
        template = drawing.model.template.with_vertices(before.vertices)
        handles = handle_points(asked + load_handles(file), pins, template, symmetric)
        start = time.perf_counter()
        edit = edit_handles(before, drawing.model, handles, settings, avoid)
        seconds = time.perf_counter() - start
        about = {"model_id": before.model_id, "norm": norm, "subdivide": levels, "seconds": seconds}
        about |= handle_figures(edit, before)
        draw = partial(picture, before, edit, drawing)
        write_face_result(files, edit.face, drawing, provenance("edit-handle", [face, file], **about), draw)
    echo_result(f"{out}: {_summary(about)}", note)


def _asked(texts, file):
    """Pairs of a place and three lengths, as they were typed; where none were there must be a file."""
    if not texts and file is None:
        raise UsageError("give at least one --handle, or --handles")
    asked = []
    for text in texts:
        where, equals, lengths = text.partition("=")
        if not equals or lengths.count(",") != 2:
            raise UsageError(f"--handle {shown(text, 60)}: expected WHERE=DX,DY,DZ, such as nose_tip=0,0,5%")
        asked.append((where, lengths.split(",")))
    return asked


def _picture(steps, baseline):
    """What draws an edit: a film strip, or before and after, perhaps with a baseline. Raises UsageError for both, and
    where none is drawn."""
    from caricli.methods.edit.handle_sheet import handle_sheet, handle_strip

    refuse_undrawn("steps", "baseline")
    if steps and baseline:
        raise UsageError("--baseline is drawn beside before and after, not in the strip of --steps: give one of them")
    return partial(handle_strip, steps=steps) if steps else partial(handle_sheet, baseline=bool(baseline))


def _summary(figures):
    """The line to print: how far the handles came, and what that did to the surface."""
    reached = 100 * min(row["reached"] for row in figures["handles"] if "reached" in row)
    shortened = "" if figures["share"] == 1 else f", shortened to {100 * figures['share']:.0f} %"
    added = {key: figures[key]["after"] - figures[key]["before"] for key in ("flipped_triangles", "crossing_pairs")}
    counts = f"flipped triangles {added['flipped_triangles']:+d}, crossing pairs {added['crossing_pairs']:+d}"
    return f"reached {reached:.0f} %{shortened}, {counts}"
