"""Sketches by path, whatever they are drawn in."""

from pathlib import Path

import numpy as np

from caricli.io.image import write_png
from caricli.io.sketch import write_sketch
from caricli.render.rasterise_sketch import rasterise_sketch
from caricli.structures.sketch import CANVAS, Sketch

LINE = 1.4
"""Pixels of a canvas of CANVAS, the width of a line in a picture; larger canvases have wider ones."""


def write_drawing(path: Path, sketch: Sketch) -> None:
    """Write a sketch as JSON, SVG or, where the name ends in .png, as a picture, black on white.

    Raises OutputError when the file cannot be written.
    """
    if path.suffix.lower() == ".png":
        side = max(sketch.size)
        ink = rasterise_sketch(sketch, side, LINE * side / CANVAS)
        write_png(path, np.repeat(255 - ink[..., None], 3, axis=2))
    else:
        write_sketch(path, sketch)
