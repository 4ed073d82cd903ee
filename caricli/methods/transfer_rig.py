"""The expressions of one head done by another, however exaggerated (portrait paper, section 3.3)."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.contact_solver import ContactSolver
from caricli.geometry.deformation_transfer import DeformationTransfer
from caricli.geometry.similarity import similarity
from caricli.methods.expression_templates import STARTS, contact_normals, start_delta


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def transfer_rig(templates, neutral, contacts=True):
    """Displacements of a face for every expression of the templates, by deformation transfer.

    What the templates never move stays where it is. Pairs of vertices that come together in an expression come together
    here too, and those that do not may get no nearer than they do in the templates, measured by the size of the face.

    templates: ExpressionTemplates. neutral: (V, 3) metres, the templates' topology, no triangle without area. contacts:
    whether pairs are kept, which the paper does not.
    Returns (K, V, 3). Raises NumericsError.
    """
    pairs = templates.pairs
    scale, rotation, _ = similarity(templates.neutral, neutral)
    transfer = DeformationTransfer(neutral, templates.faces, templates.still)
    solver = ContactSolver(transfer, pairs) if contacts else None
    usual = templates.normals @ rotation.T
    normals = contact_normals(neutral, templates.faces, pairs, scale * templates.reach, usual)
    own = neutral[pairs[:, 0]] - neutral[pairs[:, 1]]
    gaps = (own * normals).sum(1)
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
        if solver:
            targets = scale * made.offsets @ rotation.T - own
            floors = np.minimum(scale * made.gaps - gaps, 0)
            moved = solver.solve(moved, made.closed, targets, normals, floors, made.near)
        moves[k] = moved - start_delta(templates.names, moves, k)
    return moves
