"""The shape that a network deforms: of a file, or what suits the template."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming
from caricli.io.face import read_face
from caricli.template.head import load_head
from caricli.template.template import Template

UNLIKE = 2.0
"""By how much at most a template is higher or lower than that of the dataset: another unit is ten times another."""


def load_network_points(template: Template, path: Path | None = None) -> np.ndarray:
    """(V, 3) metres: the mesh of a file, or the open head with its lips apart, or else the template itself.

    Raises InputError when the file has another topology, or is of so other a size that it must be of another unit.
    """
    if path is not None:
        face = read_face(path)
        with naming(path):
            if face.mesh.topology_id != template.topology_id:
                count = len(face.vertices)
                expected = f"the dataset's topology ({len(template.vertices)} vertices)"
                raise InputError(f"expected {expected}, found another ({count} vertices)")
            height = face.mesh.height
            if not template.height / UNLIKE <= height <= template.height * UNLIKE:
                expected = f"metres, about the {template.height:.3g} that the dataset's template is high"
                raise InputError(f"expected {expected}, found {height:.3g}")
        return face.vertices
    if template.topology_id == load_head().template().topology_id:
        return load_head().open_mouth_template().vertices
    return template.vertices
