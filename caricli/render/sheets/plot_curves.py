"""Curves as a picture."""

from collections.abc import Mapping

import numpy as np

from caricli.render.figures import figure_pixels, new_figure

_SIZE = (600, 420)  # pixels, of a panel


def plot_curves(
    panels: Mapping[str, Mapping[str, tuple]],
    x_label: str = "epoch",
    y_label: str = "mean distance in % of the head's height",
) -> np.ndarray:
    """Draw curves with a logarithmic y axis, panels side by side.

    panels: dict from titles to dicts from names to (x, y) sequences; y positive. x_label, y_label: what the axes say.
    Returns (H, W, 3) uint8.
    """
    figure = new_figure(_SIZE[0] * len(panels), _SIZE[1])
    from matplotlib.ticker import LogLocator, NullFormatter

    for axes, (title, curves) in zip(np.atleast_1d(figure.subplots(1, len(panels))), panels.items(), strict=True):
        for name, (x, y) in curves.items():
            axes.semilogy(x, y, label=name, marker="o" if len(x) < 4 else None)
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 5, 7)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        axes.grid(True, which="both", alpha=0.3)
        axes.legend()
    return figure_pixels(figure)
