"""Lashes that stand on the edges of lids."""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from caricli.errors import InputError, naming
from caricli.geometry.alignment.weighted_similarities import weighted_similarities
from caricli.geometry.repair.components import component_labels
from caricli.io.kept import kept_arrays
from caricli.methods.parts.bend_lashes import Lashes
from caricli.methods.parts.flesh import Flesh, Hide
from caricli.methods.parts.pocket import spread
from caricli.methods.parts.posed import Posed
from caricli.structures import Part
from caricli.structures.arkit import uses
from caricli.template.template import Template

NEIGHBOURS = 6
"""Vertices of a lid that a lash is held by."""

REACH = 0.08
"""Of the head's height: how far from lashes skin may be that comes over them."""

OVER = 60
"""Vertices of that skin, around its root, that may come over a lash, and"""
STILL = 1e-3
"""of the height: how far an expression moves at least one of them against it, or it is not asked whether it does."""

FOLD = (0.002, 0.004)
"""Of the height: so far from the skin, at least and at most, another fold of it may cover a lash than what is
nearest."""

BEHIND = 4.0
"""Of the height: how far behind that skin it is closed, so that nothing of what closes it is before an eye."""

WAY = (0.25, 0.5, 0.75, 1.0)
"""Weights of expressions at which lashes are kept out of the skin."""


class Lids:
    """Lashes, each held by the lid around its root, and bent where another fold of skin would cover it."""

    def __init__(self, template: Template, part: Part) -> None:
        """template: whose annotation knows the eyes. part: a component of its mesh for every lash.

        Raises InputError where it is far from the skin.
        """
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.template = np.asarray(template.vertices, float)
        self.spread = spread(self.template)
        labels = component_labels(part.mesh.faces, len(self.shape))
        eyes = template.mask("eyes_left", "eyes_right")
        outside = eyes & ~template.mask("eye_socket_left", "eye_socket_right")
        lids = np.flatnonzero(outside if outside.any() else eyes)
        given = (self.template, template.faces, lids, self.shape, labels)
        with naming(part.name):
            held = kept_arrays("lashes", given, lambda: _held(*given))
        self.lashes = Lashes(self.shape, labels, held["roots"], template.height)
        self.ids = held["near"]
        distance = held["distance"]
        self.weights = np.exp(-0.5 * (distance / distance.mean(1, keepdims=True)) ** 2)
        self.hide = Hide(held["faces"])
        self.over = held["over"]

    def place(self, face: Posed) -> Part:
        """The lashes of a face."""
        size = spread(face.neutral) / self.spread
        shape = self._moved(self.template, face.neutral[None], self.shape, True)[0]
        shape = self.lashes.shortened(shape, size)
        skin = face.neutral[self.hide.ids]
        behind = self.hide.behind(skin, BEHIND * size * self.lashes.height)
        shape = self.lashes.bent({1.0: Flesh(self.hide, skin, behind, self._fold(size))}, shape, shape, size)
        deltas = self._moves(face, shape, behind) if face.names else np.zeros((0, *shape.shape))
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=face.names, deltas=deltas)

    def _moves(self, face: Posed, shape: np.ndarray, behind: np.ndarray) -> np.ndarray:
        """(K, W, 3) metres, what expressions do to lashes (W, 3) of a face. behind: (3,) metres, what the skin
        around them is closed to."""
        size = spread(face.neutral) / self.spread
        fold = self._fold(size)
        skin = face.neutral[self.hide.ids]
        moved = self._moved(face.neutral, face.neutral + face.deltas, shape, False) - shape
        together = uses(face.names)
        changes = np.tensordot(together, face.deltas[:, self.hide.ids], 1)
        # Expressions that others start from come first.
        for k in np.argsort(together.sum(1), kind="stable"):
            end = shape + np.tensordot(together[k], moved, 1)
            against = changes[k, self.over] - (end - shape)[self.lashes.roots][:, None]
            near = np.linalg.norm(against, axis=-1).max(1) > STILL * size * self.lashes.height
            if near.any():
                flesh = {weight: Flesh(self.hide, skin + weight * changes[k], behind, fold) for weight in WAY}
                moved[k] += self.lashes.bent(flesh, shape, end, size, near) - end
        return moved

    def _fold(self, size: float) -> tuple[float, float]:
        """FOLD in metres. size: of the head, to the usual one."""
        least, most = FOLD
        return least * size * self.lashes.height, most * size * self.lashes.height

    def _moved(self, before: np.ndarray, after: np.ndarray, shape: np.ndarray, scaling: bool) -> np.ndarray:
        scale, rotation, shift = weighted_similarities(before[self.ids], after[:, self.ids], self.weights, scaling)
        labels = self.lashes.labels
        turned = np.einsum("kwij,wj->kwi", rotation[:, labels], shape)
        return scale[:, labels, None] * turned + shift[:, labels]


def _held(
    template: np.ndarray, faces: np.ndarray, lids: np.ndarray, shape: np.ndarray, labels: np.ndarray
) -> dict[str, np.ndarray]:
    """What holds lashes (W, 3), and the skin that may come over them.

    template: (V, 3) metres. faces: (F, 3). lids: vertices that lashes may stand on. labels: (W,) the lash of every
    vertex, from 0 to L - 1.
    Returns roots (L,), vertices of lashes; near (L, k) those of the lids near each, and their distance; faces (H, 3) of
    the skin around; over (L, m), numbers among its vertices. Raises InputError where there is none around.
    """
    tree = KDTree(template[lids])
    distance, _ = tree.query(shape)
    lashes = [np.flatnonzero(labels == k) for k in range(labels.max() + 1)]
    roots = np.array([ids[distance[ids].argmin()] for ids in lashes])
    distance, near = tree.query(shape[roots], min(NEIGHBOURS, len(lids)))
    reached = KDTree(shape).query(template)[0] < REACH * np.ptp(template[:, 1])
    around = faces[reached[faces].all(1)]
    if not len(around):
        raise InputError(f"expected it to hang on lids, found no skin within {100 * REACH:g} % of the head's height")
    skin = template[np.unique(around)]
    over = KDTree(skin).query(shape[roots], min(OVER, len(skin)))[1]
    return {"roots": roots, "near": lids[near], "distance": distance, "faces": around, "over": over}
