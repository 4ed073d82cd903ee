"""A neck that goes down with the chin, and is as wide as it is seen."""

from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.deformation.elastic_anchors import bending_stiffness

REACH = 0.08
"""Of the head's height: how far around the neck skin goes along, about 2 cm."""

CLEARANCE = 0.06
"""Of the head's height: the least distance of the chin above the neck's front edge, half of what a usual head has."""

_HOLD = 1e-9  # of the mean diagonal: makes the system definite where nothing is held
_PULL = 1e6  # of the mean diagonal: what holds a weight where it is given


class Neck:
    """What hangs below the chin of a head that is cut off at the neck.

    Data end at the cut, so a chin that sinks below it, as drawn, would hang before the void. ``weights`` (V,) say how
    much of such a sinking a vertex makes: all on the edge and on what lies below the chin in the template, nothing on
    the face and beyond ``REACH`` of the neck, in between as a plate bends. edge: (E,) vertices of the cut.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, neck: np.ndarray, chin: int, still: np.ndarray) -> None:
        """vertices: (V, 3) template. faces: (F, 3). neck: ids, none on a head without a neck. chin: id. still: (V,)
        bool, what never goes along."""
        self.height = float(np.ptp(vertices[:, 1]))
        self.chin = chin
        self._mesh = (vertices, faces)
        self._neck = neck
        self._still = still
        self.edge = np.intersect1d(neck, igl.boundary_facets(faces)[0].ravel())
        self.front = int(self.edge[vertices[self.edge, 1].argmin()]) if len(self.edge) else chin

    @cached_property
    def weights(self) -> np.ndarray:
        """(V,) solved for on first use: few chins sink."""
        vertices, faces = self._mesh
        if not len(self.edge):
            return np.zeros(len(vertices))
        from scipy.spatial import KDTree

        neck = self._neck
        hanging = np.union1d(self.edge, neck[vertices[neck, 1] < vertices[self.chin, 1]])
        still = self._still | (KDTree(vertices[neck]).query(vertices)[0] > REACH * self.height)
        still[hanging] = False
        laplacian = -igl.cotmatrix(vertices, faces)
        plate = bending_stiffness(vertices, faces, laplacian)
        stiffness = laplacian.diagonal().mean()
        held = still.astype(float)
        held[hanging] = 1.0
        target = np.zeros((len(vertices), 1))
        target[hanging] = _PULL * stiffness
        system = laplacian + plate + stiffness * sp.diags(_PULL * held + _HOLD)
        return np.clip(Cholesky(system.tocsc()).solve(target)[:, 0], 0, 1)

    def lengthen(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with the neck as far down as the chin needs, and no farther. vertices: (V, 3)."""
        missing = vertices[self.front, 1] - vertices[self.chin, 1] + CLEARANCE * self.height
        return vertices - missing * self.weights[:, None] * [0.0, 1.0, 0.0] if missing > 0 else vertices

    def widen(self, vertices: np.ndarray, ratio: float, shift: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) whose neck is so many times as wide and deep, and moved. shift: (3,) metres, of its edge."""
        away = vertices - vertices[self.edge].mean(0)
        return vertices + self.weights[:, None] * ((ratio - 1) * away + shift)
