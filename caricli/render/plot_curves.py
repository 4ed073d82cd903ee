"""Curves as a picture."""

import io
import logging
from collections.abc import Mapping

import numpy as np


def plot_curves(
    panels: Mapping[str, Mapping[str, tuple]],
    x_label: str = "epoch",
    y_label: str = "mean distance in % of the head's height",
    size: tuple[int, int] = (900, 420),
) -> np.ndarray:
    """Draw curves with a logarithmic y axis, panels side by side.

    panels: dict from titles to dicts from names to (x, y) sequences; y positive. x_label, y_label: what the axes say.
    size: of one panel, pixels.
    Returns (H, W, 3) uint8.
    """
    # It warns of its own cache and fonts, which costs nobody but a second.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter
    from PIL import Image

    figure = Figure(figsize=(size[0] * len(panels) / 150, size[1] / 100), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    for axes, (title, curves) in zip(np.atleast_1d(figure.subplots(1, len(panels))), panels.items(), strict=True):
        for name, (x, y) in curves.items():
            axes.semilogy(x, y, label=name, marker="o" if len(x) < 4 else None)
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 5, 7)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        axes.grid(True, which="both", alpha=0.3)
        axes.legend()
    stream = io.BytesIO()
    canvas.print_png(stream)
    return np.asarray(Image.open(stream).convert("RGB"))
