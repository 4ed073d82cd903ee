"""The expressions of one head done by another, however exaggerated (portrait paper, section 3.3)."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.deformation_transfer import DeformationTransfer
from caricli.geometry.similarity import similarity
from caricli.methods.rig.expression_templates import STARTS, start_delta
from caricli.methods.rig.keep_contacts import Contacts


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def transfer_rig(templates, neutral, contacts=True):
    """Displacements of a face for every expression of the templates, by deformation transfer.

    What the templates never move stays where it is.

    templates: ExpressionTemplates. neutral: (V, 3) metres, the templates' topology, no triangle without area. contacts:
    whether what touches keeps touching (``Contacts``), of which the paper says nothing.
    Returns (K, V, 3). Raises NumericsError.
    """
    scale, rotation, _ = similarity(templates.neutral, neutral)
    transfer = DeformationTransfer(neutral, templates.faces, templates.still)
    kept = Contacts(templates, neutral, transfer) if contacts else None
    moves = np.zeros((len(templates.names), *neutral.shape))
    for k in sorted(range(len(moves)), key=lambda k: templates.names[k] in STARTS):
        made = templates.motions[k]
        if made is None:
            continue
        maps = rotation @ made.maps @ rotation.T
        # Where the template hardly moves the face does the same: what the shapes' difference adds up to stays inside.
        same = scale * made.moved @ rotation.T
        moved = transfer.displacements(made.triangles, maps, same.mean(0))
        moved = same + made.trust[:, None] * (moved - same)
        if kept:
            moved = kept.keep(k, moved)
        moves[k] = moved - start_delta(templates.names, moves, k)
    return moves
