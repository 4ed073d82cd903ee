"""caricli refine-gesture: strokes on a face that change it."""

from functools import partial

import click

from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    named_mesh,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.commands.shared.picture import SIZE, picture_option
from caricli.errors import naming
from caricli.io.provenance import provenance


@click.command()
@click.argument("face", type=PATH, metavar="FACE")
@click.option(
    "--script", required=True, type=PATH, metavar="SESSION.json", help="Do the operations of this session, in turn."
)
@out_option("REFINED.obj", f"Write the face here, {FACE_FILES}", check=named_mesh)
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
def command(face, script, out, head, levels, overwrite):
    """Change a face (NPZ, OBJ, PLY, GLB or glTF) by strokes on it (sketch paper, section 3.3), without a page.

    The script is a session as `caricli studio` writes it (docs/formats.md): brushed handles, a region of interest,
    lines that handles or the outline go to, bulges and depressions; `gesture` is a stroke as it was drawn, which a
    network takes for one of them, or for undo or redo. What the script began with does not count. What the latent
    cannot express stays on the face.

    \b
    Example:
      caricli refine-gesture face.npz --script session.json --out refined.obj
    """
    from caricli.io.session import read_session
    from caricli.methods.edit.refined_sheet import refined_sheet
    from caricli.methods.session.play_gestures import play_gestures
    from caricli.methods.session.pose import Poser
    from caricli.store.drawings import load_drawing
    from caricli.store.face_files import write_face_result
    from caricli.store.session_tools import SessionTools, load_start

    session = read_session(script)
    drawing = load_drawing(None, levels, SIZE, head)
    with staged_face(out, overwrite, (face, script), "refining") as files:
        tools = SessionTools()
        start = load_start(face, tools)
        with naming(script):
            history = play_gestures(start, session.operations, tools)
            refined = Poser(tools).face(history.work)
        about = {"model_id": tools.model.model_id, "subdivide": levels} | _figures(history, start.face, refined)
        draw = partial(refined_sheet, start.face, refined, drawing)
        description = provenance("refine-gesture", [face, script], **about)
        write_face_result(files, refined, drawing, description, draw)
    echo_result(f"{out}: {len(about['operations'])} operations, moved at most {1000 * about['moved']:.1f} mm")


def _figures(history, before, after):
    """What the report says: the operations that were done, and the longest way of a vertex in metres.

    before, after: EncodedFaces.
    """
    import numpy as np

    from caricli.io.session import operation_to_json

    moved = np.linalg.norm(after.vertices - before.vertices, axis=1).max()
    return {"operations": [operation_to_json(each) for each in history.done], "moved": float(moved)}
