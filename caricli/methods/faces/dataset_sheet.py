"""Random meshes of a dataset on one picture."""

import numpy as np

from caricli.methods.parts.whole_head import whole_head
from caricli.render.backdrop import row_of
from caricli.render.head_views import head_views
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.structures import Face
from caricli.template.template import Template


def dataset_sheet(
    shapes: np.ndarray, template: Template, count: int, size: int, generator: np.random.Generator
) -> np.ndarray:
    """Front and three-quarter views of randomly chosen shapes, as whole heads.

    shapes: (N, V, 3) metres. template: Template of their topology. count: meshes on the sheet. size: pixels of a view.
    generator: numpy Generator.
    Returns (H, W, 3) uint8.
    """
    chosen = np.sort(generator.choice(len(shapes), min(count, len(shapes)), replace=False))
    heads = (whole_head(Face(template.with_vertices(shape)), template) for shape in shapes[chosen])
    return contact_sheet([row_of(head_views(head, ("front", "three-quarter"), size)) for head in heads])
