"""Where on a head errors are."""

import io
import logging
from collections.abc import Mapping

import numpy as np

from caricli.structures import Mesh


def error_maps(mesh: Mesh, errors: Mapping[str, np.ndarray], size: int = 360) -> np.ndarray:
    """Draw heads from the front in colours of one scale, side by side.

    mesh: Mesh, front along +z. errors: (V,) not negative, by titles. size: pixels, width of a head.
    Returns (H, W, 3) uint8.
    """
    # It warns of its own cache and fonts, which costs nobody but a second.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.flatnonzero(normals[:, 2] > 0)
    order = front[np.argsort(corners[front, :, 2].mean(1))]  # what is in front is drawn last
    most = max(float(np.percentile(values, 99)) for values in errors.values())
    figure = Figure(figsize=(size * len(errors) / 100 + 0.8, size * 1.5 / 100), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
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
    stream = io.BytesIO()
    canvas.print_png(stream)
    return np.asarray(Image.open(stream).convert("RGB"))
