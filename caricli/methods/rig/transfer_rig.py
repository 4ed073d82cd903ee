"""The expressions of one head done by another, however exaggerated (portrait paper, section 3.3)."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.deformation_transfer import DeformationTransfer
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.keep_contacts import Contacts
from caricli.structures.arkit import start_delta


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def transfer_rig(templates: ExpressionTemplates, vertices: np.ndarray, contacts: bool = True) -> np.ndarray:
    """Displacements of a face for every expression of the templates, by deformation transfer.

    What the templates never move stays where it is.

    vertices: (V, 3) metres, of the neutral face, in the templates' topology, no triangle without area.
    contacts: whether what touches keeps touching (``Contacts``), of which the paper says nothing.
    Returns (K, V, 3). Raises NumericsError.
    """
    scale, rotation, _ = similarity(templates.neutral, vertices)
    transfer = DeformationTransfer(vertices, templates.faces, templates.still)
    keeper = Contacts(templates, vertices, transfer) if contacts else None
    deltas = np.zeros((len(templates.names), *vertices.shape))
    for k in templates.order:
        motion = templates.motions[k]
        if motion is None:
            continue
        maps = rotation @ motion.maps @ rotation.T
        # Where the template hardly moves the face does the same: what the shapes' difference adds up to stays inside.
        same = scale * motion.moved @ rotation.T
        moved = transfer.displacements(motion.triangles, maps, same)
        moved = same + motion.trust[:, None] * (moved - same)
        if keeper:
            moved = keeper.keep(k, moved)
        deltas[k] = moved - start_delta(templates.names, deltas, k)
    return deltas
