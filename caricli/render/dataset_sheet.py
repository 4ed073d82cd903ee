"""Random meshes of a dataset on one picture."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.head_views import head_views


def dataset_sheet(shapes, faces, annotation, count, size, generator):
    """Front and three-quarter views of randomly chosen shapes.

    shapes: (N, V, 3). faces: (F, 3). annotation: with ``curves`` and ``regions``. count: meshes on the sheet. size:
    pixels of a view. generator: numpy Generator.
    Returns (H, W, 3) uint8.
    """
    chosen = np.sort(generator.choice(len(shapes), min(count, len(shapes)), replace=False))
    pairs = [head_views(shape, faces, annotation, ("front", "three-quarter"), size) for shape in shapes[chosen]]
    return contact_sheet([np.hstack(pair) for pair in pairs])
