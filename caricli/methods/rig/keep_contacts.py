"""Lids and lips that meet where those of the templates meet, and never pass through each other."""

import numpy as np

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.deformation_transfer import DeformationTransfer
from caricli.geometry.repair.contact_solver import Conditions, ContactSolver
from caricli.methods.rig.expression_templates import ExpressionTemplates, contact_normals

ASTRAY = 5
"""Reaches that a vertex may pass its partner by: nothing goes so far through anything, so the lips were crossed before,
and the normal points the wrong way."""


class Contacts:
    """What the pairs of vertices of ExpressionTemplates have to keep on another face.

    Pairs that come together in an expression come together here too, and those that do not may get no nearer than they
    do in the templates, measured by the size of the face.
    """

    def __init__(self, templates: ExpressionTemplates, vertices: np.ndarray, transfer: DeformationTransfer) -> None:
        """vertices: (V, 3) of the face, metres. transfer: DeformationTransfer of the face."""
        pairs = templates.pairs
        self.templates = templates
        self.scale, self.rotation, _ = similarity(templates.neutral, vertices)
        self.solver = ContactSolver(transfer, pairs)
        usual = templates.normals @ self.rotation.T
        mesh = templates.mesh.with_vertices(vertices)
        self.normals = contact_normals(mesh, pairs, self.scale * templates.reach, usual)
        self.own = vertices[pairs[:, 0]] - vertices[pairs[:, 1]]
        self.gaps = (self.own * self.normals).sum(1)

    def rest(self) -> np.ndarray:
        """Displacements (V, 3) of the face so that what touches in the templates' neutral face touches here, too.

        Held along their normals alone, lips slip past each other and cross.
        """
        templates = self.templates
        pairs = templates.pairs
        offsets = templates.neutral[pairs[:, 0]] - templates.neutral[pairs[:, 1]]
        closed = np.linalg.norm(offsets, axis=1) < templates.reach
        floors = (self.scale * (offsets * templates.normals).sum(1) - self.gaps).clip(max=0)
        targets = self.scale * offsets @ self.rotation.T - self.own
        still = np.zeros((len(self.solver.rows), 3))
        return self.solver.solve(still, Conditions(closed, targets, self.normals, floors))

    def keep(self, k: int, moved: np.ndarray) -> np.ndarray:
        """The displacements (V, 3) of expression k, nearest to ``moved`` (V, 3), that keep the contacts."""
        motion = self.templates.motions[k]
        if motion is None:
            return moved
        targets = self.scale * motion.offsets @ self.rotation.T - self.own
        floors = (self.scale * motion.gaps - self.gaps).clip(max=0)
        gaps = moved[self.templates.pairs[:, 0]] - moved[self.templates.pairs[:, 1]]
        astray = (gaps * self.normals).sum(1) < floors - ASTRAY * self.scale * self.templates.reach
        floors = np.where(astray, -np.inf, floors)
        return self.solver.solve(moved, Conditions(motion.closed, targets, self.normals, floors), motion.near)
