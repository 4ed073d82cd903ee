"""Sketches beside the faces that were made of them (sketch paper, figure 8)."""

import numpy as np

from caricli.render.head_views import head_sky, head_views
from caricli.render.shade import Look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.template.template import Template

_SIDE = 256


def sketch_gallery(template: Template, windows: np.ndarray, pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Rows of two: a sketch, the face that was made of it, and the true face.

    template: Template. windows: (N, S, S) uint8 ink. pairs: N of vertices (V, 3), made and true.
    Returns (H, W, 3) uint8.
    """
    pictures = []
    for window, pair in zip(windows, pairs, strict=True):
        pictures.append(_paper(window))
        pictures += [_front(template.with_vertices(vertices)) for vertices in pair]
    return contact_sheet(pictures, 6, ["sketch", "from the sketch", "true"] * len(pairs))


def _paper(window: np.ndarray) -> np.ndarray:
    import cv2

    large = cv2.resize(255 - window, (_SIDE, _SIDE), interpolation=cv2.INTER_LINEAR)
    return np.repeat(large[..., None], 3, 2)


def _front(head: Template) -> np.ndarray:
    return head_views(head, ("front",), _SIDE, None, Look(visibility=head_sky(head)))[0]
