"""Lay the bundled head out in its picture: python make_layout.py OUT.npz."""

import sys

from caricli.io.npz import write_npz
from caricli.methods.texture.lay_out_head import lay_out_head
from caricli.template.annotation import bundled_annotation
from caricli.template.head import load_head
from caricli.template.template import Template


def main(path: str) -> None:
    """Write the layout as the package bundles it."""
    head = load_head()
    bare = Template(head.evaluate(), head.polygons, annotation=bundled_annotation())
    mesh = lay_out_head(bare)
    assert mesh.uvs is not None and mesh.uv_polygons is not None
    write_npz(path, {"uvs": mesh.uvs, "uv_polygons": mesh.uv_polygons})


if __name__ == "__main__":
    main(sys.argv[1])
