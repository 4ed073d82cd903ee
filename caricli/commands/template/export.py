"""caricli template export: the head as a file."""

import click

from caricli.commands.shared.options import PATH, named_mesh, overwrite_option
from caricli.io.outputs import staged


@click.command()
@click.argument("out", type=PATH, metavar="OUT.obj", callback=named_mesh)
@click.option("--open-mouth", is_flag=True, help="Write the head that networks deform, its lips apart.")
@overwrite_option
def command(out, open_mouth, overwrite):
    """Write the head as a mesh in metres, Y up, +Z out of the face.

    OBJ has its quads and UVs, GLB and glTF triangles and UVs, PLY and STL triangles.

    \b
    Example:
      caricli template export head.obj
      caricli template export head_open.obj --open-mouth
    """
    from caricli.io.mesh import write_mesh
    from caricli.template.head import load_head

    with staged(out, overwrite=overwrite) as (temporary,):
        head = load_head()
        template = head.open_mouth_template() if open_mouth else head.template()
        write_mesh(temporary, template)
    click.echo(f"{out}: {len(template.vertices)} vertices, {len(template.polygons)} polygons")
