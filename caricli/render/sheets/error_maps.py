"""Where on a head errors are."""

from collections.abc import Mapping

import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.figures import figure_pixels, new_figure
from caricli.structures import Mesh

_WIDTH = 360  # pixels, of a head


def error_maps(mesh: Mesh, errors: Mapping[str, np.ndarray]) -> np.ndarray:
    """Draw heads from the front in colours of one scale, side by side.

    mesh: Mesh, front along +z. errors: (V,) not negative, by titles.
    Returns (H, W, 3) uint8.
    """
    front = np.flatnonzero(triangle_normals(mesh.vertices, mesh.faces)[:, 2] > 0)
    order = front[np.argsort(mesh.vertices[mesh.faces[front], 2].mean(1))]  # what is in front is drawn last
    most = max(float(np.percentile(values, 99)) for values in errors.values())
    figure = new_figure(_WIDTH * len(errors) + 80, 1.5 * _WIDTH)
    axes = np.atleast_1d(figure.subplots(1, len(errors)))
    x, y, _ = mesh.vertices.T
    for own, (title, values) in zip(axes, errors.items(), strict=True):
        shown = own.tripcolor(
            x, y, mesh.faces[order], facecolors=values[mesh.faces[order]].mean(1), cmap="viridis", vmin=0, vmax=most
        )
        own.set_aspect("equal")
        own.set_axis_off()
        own.set_title(title, fontsize=9)
    figure.colorbar(shown, ax=list(axes), label="mm")
    return figure_pixels(figure)
