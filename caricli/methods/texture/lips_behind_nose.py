"""Lips that a drawn nose hangs over."""

import numpy as np

from caricli.render.visibility.vertex_pixels import vertex_pixels
from caricli.structures import Camera
from caricli.structures.parsing import Region
from caricli.template.template import Template


def lips_behind_nose(head: Template, camera: Camera, regions: np.ndarray) -> np.ndarray:
    """(H, W) bool: pixels where a head has lips and its picture a nose, which is no paint for them.

    head: Template in the shape of the face. camera: Camera of the picture. regions: (H, W) values of Region.
    """
    rows, columns = regions.shape
    return vertex_pixels(head, head.mask("lips"), camera, (columns, rows)) & (regions == Region.NOSE)
