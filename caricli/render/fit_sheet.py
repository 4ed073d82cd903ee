"""A landmark fit on one picture: what was given, what was fitted, from several sides."""

import numpy as np
from PIL import Image

from caricli.render.contact_sheet import contact_sheet
from caricli.render.head_views import head_views
from caricli.render.overlay import draw_landmarks, overlay_mesh
from caricli.render.place_eyeballs import place_eyeballs
from caricli.structures import Mesh

GIVEN, FITTED = (30, 160, 70), (215, 40, 40)
_MARGIN = 0.35


def fit_sheet(vertices, faces, annotation, given, fitted, camera, image=None, size=512, fine=None):
    """Picture with given (green circles) and fitted (red) landmarks, mesh over the picture, three views.

    vertices: (V, 3). faces: (F, 3). annotation: with ``curves`` and ``regions``. given, fitted: (L, 2) pixels, NaN
    where unknown. camera: Camera. image: (H, W, 3) uint8, white where there is
    none. size: pixels of one view. fine: a subdivision to draw in the views, as in `head_views`.
    Returns (H, W, 3) uint8.
    """
    eyeballs = place_eyeballs(vertices, faces, annotation.curves, annotation.regions)
    projected = camera.project(vertices)
    low, high = np.nanmin(given, axis=0), np.nanmax(given, axis=0)
    if image is None:
        low, high = np.minimum(low, projected.min(0)), np.maximum(high, projected.max(0))
    corner = low - _MARGIN * (high - low).max()
    window = float((high - low).max() * (1 + 2 * _MARGIN))
    corner = (low + high - window) / 2
    picture = _crop(image, corner, window, size)
    zoom = size / window
    given, fitted = (given - corner) * zoom, (fitted - corner) * zoom
    dotted = draw_landmarks(picture, fitted, FITTED)
    marked = draw_landmarks(dotted, given, GIVEN, radius=max(1.5, size / 120), hollow=True, lines=False)
    over = overlay_mesh(picture, Mesh(vertices, faces), camera.zoomed(zoom, corner), eyeballs=eyeballs)
    views = head_views(vertices, faces, annotation, ("front", "three-quarter", "profile"), size, fine)
    return contact_sheet([marked, over, *views], columns=5)


def _crop(image, corner, window, size):
    if image is None:
        return np.full((size, size, 3), 255, dtype=np.uint8)
    box = (*corner, *(corner + window))
    return np.asarray(
        Image.fromarray(image).transform(
            (size, size), Image.Transform.EXTENT, box, Image.Resampling.BICUBIC, fillcolor="white"
        )
    )
