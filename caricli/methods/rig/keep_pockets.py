"""Mouth cavity and eye sockets that no expression brings out through the skin."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.repair.resting_pockets import RestingPockets
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.structures.arkit import start_delta
from caricli.template.template import Template


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def keep_pockets(templates: ExpressionTemplates, vertices: np.ndarray, deltas: np.ndarray) -> np.ndarray:
    """Displacements that leave the pockets behind the skin of each expression, as far as the templates name them.

    Far from people, skin may move and what is behind it stay: then it shows.

    templates: ExpressionTemplates. vertices: (V, 3) metres, of the neutral face. deltas: (K, V, 3) metres, of each
    expression alone. Returns (K, V, 3); those of expressions that bring nothing out are as they were.
    """
    if not isinstance(templates.mesh, Template):
        return deltas
    scale, *_ = similarity(templates.neutral, vertices)
    pockets = RestingPockets(templates.mesh.cavities, vertices / scale)
    kept = np.array(deltas)
    for k in templates.order:
        shape = (vertices + start_delta(templates.names, kept, k) + kept[k]) / scale
        kept[k] += scale * (pockets.withdraw(shape) - shape)
    return kept
