"""Lids and lips that meet where those of the templates meet, and never pass through each other."""

import numpy as np

from caricli.geometry.contact_solver import ContactSolver
from caricli.geometry.similarity import similarity
from caricli.methods.rig.expression_templates import contact_normals

_ASTRAY = 5


class Contacts:
    """What the pairs of vertices of ExpressionTemplates have to keep on another face.

    Pairs that come together in an expression come together here too, and those that do not may get no nearer than they
    do in the templates, measured by the size of the face.
    """

    def __init__(self, templates, vertices, transfer):
        """templates: ExpressionTemplates. vertices: (V, 3) of the face. transfer: DeformationTransfer of the face."""
        self.templates, pairs = templates, templates.pairs
        self.scale, self.rotation, _ = similarity(templates.neutral, vertices)
        self.solver = ContactSolver(transfer, pairs)
        usual = templates.normals @ self.rotation.T
        self.normals = contact_normals(vertices, templates.faces, pairs, self.scale * templates.reach, usual)
        self.own = vertices[pairs[:, 0]] - vertices[pairs[:, 1]]
        self.gaps = (self.own * self.normals).sum(1)

    def keep(self, k, moved):
        """The displacements (V, 3) of expression k, nearest to ``moved`` (V, 3), that keep the contacts."""
        made = self.templates.motions[k]
        targets = self.scale * made.offsets @ self.rotation.T - self.own
        floors = (self.scale * made.gaps - self.gaps).clip(max=0)
        gaps = moved[self.templates.pairs[:, 0]] - moved[self.templates.pairs[:, 1]]
        # Nothing goes so far through anything: the lips were crossed before, and the normal points the wrong way.
        astray = (gaps * self.normals).sum(1) < floors - _ASTRAY * self.scale * self.templates.reach
        floors = np.where(astray, -np.inf, floors)
        return self.solver.solve(moved, made.closed, targets, self.normals, floors, made.near)
