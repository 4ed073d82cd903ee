"""Random meshes of a dataset on one picture."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.views import render_views


def dataset_sheet(shapes, faces, annotation, count, size, generator):
    """Front and three-quarter views of randomly chosen shapes.

    shapes: (N, V, 3). faces: (F, 3). annotation: with ``curves`` and ``regions``. count: meshes on the sheet. size:
    pixels of a view. generator: numpy Generator.
    Returns (H, W, 3) uint8.
    """
    chosen = np.sort(generator.choice(len(shapes), min(count, len(shapes)), replace=False))
    strips = []
    for shape in shapes[chosen]:
        eyeballs = place_eyeballs(shape, faces, annotation.curves, annotation.regions)
        strips.append(np.hstack(render_views(shape, faces, ("front", "three-quarter"), size, eyeballs=eyeballs)))
    return contact_sheet(strips)
