"""A square out of a picture."""

import numpy as np
from PIL import Image

from caricli.render.backdrop import PAPER


def cut_square(picture: np.ndarray, corner: np.ndarray, side: float, size: int) -> np.ndarray:
    """A square of a picture in another size; thin lines of large pictures stay whole.

    picture: (H, W, 3) uint8. corner: (2,) pixels, from the corner of the first one. side: pixels. size: pixels, side of
    the result.
    Returns (size, size, 3) uint8, paper beyond the picture.
    """
    image = Image.fromarray(picture)
    # The transform takes single samples, however many pixels lie between them.
    step = max(int(side / size), 1)
    if step > 1:
        image = image.reduce(step)
    box = (*(corner / step), *((corner + side) / step))
    extent = Image.Transform.EXTENT
    return np.asarray(image.transform((size, size), extent, box, Image.Resampling.BICUBIC, fillcolor=PAPER))
