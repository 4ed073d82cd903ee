"""What it costs to bend the surface of a head."""

from functools import lru_cache

import igl
import numpy as np
import scipy.sparse as sp

from caricli.template.template import Template


@lru_cache(maxsize=4)
def bending(template: Template) -> sp.csr_matrix:
    """(V, V) what bending the surface of a template costs."""
    vertices = np.asarray(template.vertices, float)
    laplacian = igl.cotmatrix(vertices, template.faces)
    mass = igl.massmatrix(vertices, template.faces).diagonal()
    return sp.csr_matrix(laplacian @ sp.diags(1 / mass) @ laplacian)
