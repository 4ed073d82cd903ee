"""caricli edit-semantic: more or less of what labels name."""

from functools import partial

import click

from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    WholeRange,
    directions_option,
    model_option,
    named_mesh,
    named_numbers,
    out_option,
    overwrite_option,
    refuse_typed,
    subdivide_option,
)
from caricli.commands.shared.picture import SIZE, picture_option, refuse_undrawn
from caricli.commands.shared.tables import print_directions
from caricli.io.provenance import provenance


@click.command()
@click.argument("face", required=False, type=PATH)
@click.option(
    "--label",
    "labels",
    multiple=True,
    metavar="NAME=S",
    help="Go towards a label by S standard deviations; repeat for more.",
)
@out_option("EDITED.obj", f"Write the face here, {FACE_FILES}", required=False, check=named_mesh)
@click.option("--keep", multiple=True, metavar="NAME", help="Change this label as little as possible; repeat for more.")
@click.option(
    "--steps",
    type=WholeRange(2, 25),
    metavar="N",
    help="Draw a strip of N faces, from minus to plus the strengths.",
)
@click.option("--list", "listed", is_flag=True, help="Print the labels and how well each is known, and stop.")
@directions_option
@model_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
def command(face, labels, out, keep, steps, listed, directions, model, head, levels, overwrite):
    """Give a face (NPZ, OBJ, PLY, GLB or glTF) more of a label, or less with a negative strength.

    Strengths are in standard deviations of faces. What the latent cannot express stays on the face, so the opposite
    strength takes it back. A face without a latent is encoded first. The picture shows the face before and after, or
    with --steps a film strip from minus to plus the strengths.

    \b
    Example:
      caricli edit-semantic --list
      caricli edit-semantic face.npz --label BigNose=2 --label Smile=-1 --out edited.obj
      caricli edit-semantic face.npz --label BigNose=3 --keep BigMouth --steps 5 --out strip.obj
    """
    from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic
    from caricli.methods.edit.semantic_strip import semantic_strip
    from caricli.methods.faces.face_figures import face_figures
    from caricli.store.directions import directions_path, load_directions
    from caricli.store.drawings import load_drawing
    from caricli.store.face_files import write_face_result
    from caricli.store.faces import load_latent_face

    _check_usage(listed, face is not None and out is not None and labels)
    drawing = load_drawing(model, levels, SIZE, head)
    path = directions_path(directions, drawing.model)
    if listed:
        return print_directions(load_directions(drawing.model, path))
    strengths = named_numbers("--label", labels, "NAME=STRENGTH, such as BigNose=2", "label")
    edit = SemanticEdit(load_directions(drawing.model, path), strengths, keep)
    with staged_face(out, overwrite, (face, model, path), "editing") as files:
        before, note = load_latent_face(face, drawing.model, anew=model is None)
        after = edit_semantic(before, drawing.model, edit)
        about = {"model_id": after.model_id, "labels": strengths, "keep": keep, "subdivide": levels}
        about |= {name: face_figures(each, drawing.model) for name, each in (("before", before), ("after", after))}
        draw = partial(semantic_strip, before, edit, drawing, steps)
        write_face_result(files, after, drawing, provenance("edit-semantic", [face, path], **about), draw)
    flipped = 100 * about["after"]["flipped"]
    echo_result(f"{out}: {' '.join(labels)}, prior {after.prior_rms:.2f}, flipped triangles {flipped:.3f} %", note)


def _check_usage(listed, complete):
    """Refuse what is not enough, and options that say nothing beside others. complete: whether a face can be edited."""
    refuse_undrawn("steps")
    if listed:
        message = "--list prints the labels, and stops: it takes no FACE, --label, --keep, --steps and --out."
        refuse_typed(message, "face", "labels", "keep", "steps", "out")
    elif not complete:
        raise click.UsageError("Give a FACE, at least one --label and --out; or --list.")
