"""Displacements corrected so that what touches touches, and nothing goes through."""

import numpy as np

SOFTNESS = 1e-3
ROUNDS = 6
_SLACK = 1e-4


class ContactSolver:
    """Deformation transfer with conditions on pairs of vertices, on top of its one factorisation.

    Minimises ``|x - x_0|_A^2 + 1/e |n_r . (x_a - x_b) - v_r|^2`` over conditions r, with A the system of the transfer:
    by Woodbury's identity a dense system as large as the number of conditions. Pairs that close have a condition along
    each axis; of the others, those that would come nearer than they may, along their normal (an active set).
    """

    def __init__(self, transfer, pairs):
        """transfer: DeformationTransfer. pairs: (P, 2) vertex ids, distinct in each row."""
        self.pairs = pairs
        # Only what is free moves; -1 is held.
        self.rows = np.full(transfer.count, -1)
        self.rows[transfer.free] = np.arange(len(transfer.free))
        # Column by column in memory, as they are solved.
        right = np.zeros((len(transfer.free), len(pairs)), order="F")
        for ends, sign in zip(self.rows[pairs].T, (1.0, -1.0), strict=True):
            free = np.flatnonzero(ends >= 0)
            right[ends[free], free] = sign
        self.responses = transfer.solve(right).T
        first, second = (np.where(ends >= 0, self.responses[:, ends], 0.0) for ends in self.rows[pairs].T)
        self.compliance = first - second
        self.softness = SOFTNESS * max(float(np.diag(self.compliance).mean()), 1e-300) if len(pairs) else 0.0

    def solve(self, moved, closed, targets, normals, floors, share=1.0):
        """Displacements nearest to given ones under the conditions.

        moved: (V, 3). closed: (P,) bool. targets: (P, 3), what the pairs that close come to, as the difference of
        their displacements. normals: (P, 3) unit, from the second to the first. floors: (P,) least difference of
        displacements along the normal. share: how much of the correction every vertex takes, (V,) or a number.
        Returns (V, 3).
        """
        gaps = moved[self.pairs[:, 0]] - moved[self.pairs[:, 1]]
        slack = _SLACK * np.abs(gaps).max(initial=0.0)
        active = ~closed & ((gaps * normals).sum(1) < floors - slack)
        if not closed.any() and not active.any():
            return moved
        for _ in range(ROUNDS):
            which = np.concatenate([np.repeat(np.flatnonzero(closed), 3), np.flatnonzero(active)])
            directions = np.concatenate([np.tile(np.eye(3), (closed.sum(), 1)), normals[active]])
            values = np.concatenate([targets[closed].ravel(), floors[active]])
            system = (directions @ directions.T) * self.compliance[np.ix_(which, which)]
            missing = values - (directions * gaps[which]).sum(1)
            forces = np.linalg.solve(system + self.softness * np.eye(len(which)), missing)
            pulls = np.zeros((len(self.pairs), 3))
            np.add.at(pulls, which, forces[:, None] * directions)
            found = gaps + self.compliance @ pulls
            released = np.zeros(len(closed), dtype=bool)
            released[np.flatnonzero(active)[forces[3 * closed.sum() :] < 0]] = True
            violated = ~closed & ~active & ((found * normals).sum(1) < floors - slack)
            if not released.any() and not violated.any():
                break
            active = (active & ~released) | violated
        pulling, corrected = np.flatnonzero(pulls.any(axis=1)), np.array(moved)
        takes = np.flatnonzero((np.broadcast_to(share, len(moved)) != 0) & (self.rows >= 0))
        answer = self.responses[np.ix_(pulling, self.rows[takes])].T @ pulls[pulling]
        corrected[takes] += np.broadcast_to(share, len(moved))[takes, None] * answer
        return corrected
