"""Sketches by path, whatever they are drawn in."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming
from caricli.io.image import is_image_file, read_image, write_png
from caricli.io.sketches.sketch import read_sketch, write_sketch
from caricli.methods.sketch.clean_drawing import clean_drawing
from caricli.methods.sketch.page_frames import page_frames
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.structures.sketch import CANVAS, Sketch

LINE = 1.4
"""Pixels of a canvas of CANVAS, the width of a line in a picture; larger canvases have wider ones."""


_SHORTEST = 0.1
"""Of the canvas's longer side: what all lines of a sketch are long together, at least."""
_INSIDE = 0.5
"""Share of the points that lie on the canvas, at least."""


def load_sketch(path: Path) -> Sketch:
    """The sketch of a file: JSON or SVG, or a picture of a drawing on paper; without a frame around it.

    Raises InputError when it is none, there is hardly a line, or most lies beside the canvas.
    """
    if is_image_file(path):
        image = read_image(path, any_ink=True)
        with naming(path):
            return clean_drawing(image)
    sketch = read_sketch(path)
    nameless = [number for number, stroke in enumerate(sketch.strokes) if stroke.curve is None]
    frames = {nameless[k] for k in page_frames([sketch.strokes[number].points for number in nameless])}
    sketch = sketch.with_strokes(stroke for number, stroke in enumerate(sketch.strokes) if number not in frames)
    with naming(path):
        length = sum(stroke.length for stroke in sketch.strokes)
        if length < _SHORTEST * max(sketch.size):
            raise InputError(
                f"expected a sketch of lines, found {len(sketch.strokes)} strokes, {length:.3g} pixels long"
            )
        points = np.concatenate([stroke.points for stroke in sketch.strokes])
        inside = ((points > -0.5) & (points < np.array(sketch.size) - 0.5)).all(1).mean()
        if inside < _INSIDE:
            canvas = f"{sketch.size[0]} x {sketch.size[1]}"
            raise InputError(
                f"expected lines on the canvas of {canvas} pixels, found {100 * inside:.0f} % of them there"
            )
    return sketch


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
