"""caricli template export: the head as a file."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, named_mesh, overwrite_option, refuse_typed
from caricli.io.image import write_png
from caricli.io.outputs import staged


@click.command()
@click.argument("out", type=PATH, metavar="OUT.obj", callback=named_mesh)
@click.option("--open-mouth", is_flag=True, help="Write the head that networks deform, its lips apart.")
@click.option(
    "--uv-sheet",
    "sheet",
    type=PATH,
    metavar="SHEET.png",
    help="Draw where everything lies in a texture, to paint over.",
)
@click.option(
    "--size", type=WholeRange(256, 4096), default=2048, metavar="PIXELS", help="Draw the sheet this wide and high."
)
@overwrite_option
def command(out, open_mouth, sheet, size, overwrite):
    """Write the head as a mesh in metres, Y up, +Z out of the face.

    OBJ has its quads and UVs, GLB and glTF triangles and UVs, PLY and STL triangles. The sheet names the regions of the
    texture and lies over it as a layer: polygons in grey, seams in red, left and right the subject's.

    \b
    Example:
      caricli template export head.obj
      caricli template export head_open.obj --open-mouth
      caricli template export head.obj --uv-sheet sheet.png
    """
    from caricli.io.meshes.mesh import write_mesh
    from caricli.render.sheets.uv_sheet import uv_sheet
    from caricli.template.head import load_head

    if sheet is None:
        refuse_typed("--size is of the sheet of --uv-sheet.", "size")
    outputs = [path for path in (out, sheet) if path is not None]
    with staged(*outputs, overwrite=overwrite) as (mesh, *pictures):
        head = load_head()
        template = head.open_mouth_template() if open_mouth else head.template()
        write_mesh(mesh, template)
        for picture in pictures:
            write_png(picture, uv_sheet(template, size))
    echo_result(f"{out}: {len(template.vertices)} vertices, {len(template.polygons)} polygons")
