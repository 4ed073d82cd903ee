"""Displacements corrected so that what touches touches, and nothing goes through."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.deformation.deformation_transfer import DeformationTransfer

SOFTNESS = 1e-3
"""Of the mean compliance of a pair: how far a condition gives way, so that those that contradict each other are met
nearly instead of making the system singular."""

ROUNDS = 6
"""Changes of the active set, at most: it may come back to where it was."""

_SLACK = 1e-4  # of the largest gap: a condition broken by less counts as kept


@dataclass(frozen=True, eq=False)
class Conditions:
    """What pairs of vertices have to keep.

    closed: (P,) bool, pairs that close.
    targets: (P, 3) metres, what those come to, as the difference of their displacements.
    normals: (P, 3) unit, from the second vertex to the first.
    floors: (P,) metres, least difference of displacements of the others along the normal.
    """

    closed: np.ndarray
    targets: np.ndarray
    normals: np.ndarray
    floors: np.ndarray

    def broken(self, gaps: np.ndarray, slack: float) -> np.ndarray:
        """(P,) bool: pairs that do not close and have come too near, by their gaps (P, 3)."""
        return ~self.closed & ((gaps * self.normals).sum(1) < self.floors - slack)

    def rows(self, active: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Conditions of the pairs that close and of the active ones: pairs (R,), directions (R, 3) and values (R,)."""
        which = np.concatenate([np.repeat(np.flatnonzero(self.closed), 3), np.flatnonzero(active)])
        directions = np.concatenate([np.tile(np.eye(3), (self.closed.sum(), 1)), self.normals[active]])
        return which, directions, np.concatenate([self.targets[self.closed].ravel(), self.floors[active]])


class ContactSolver:
    """Deformation transfer with conditions on pairs of vertices, on top of its one factorisation.

    Minimises ``|x - x_0|_A^2 + 1/e |n_r . (x_a - x_b) - v_r|^2`` over conditions r, with A the system of the transfer:
    by Woodbury's identity a dense system as large as the number of conditions. Pairs that close have a condition along
    each axis; of the others, those that would come nearer than they may, along their normal (an active set).
    """

    def __init__(self, transfer: DeformationTransfer, pairs: np.ndarray) -> None:
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

    def solve(self, moved: np.ndarray, conditions: Conditions, share: np.ndarray | float = 1.0) -> np.ndarray:
        """Displacements nearest to given ones under conditions.

        moved: (V, 3) metres. conditions: Conditions of the pairs. share: how much of the correction every vertex takes,
        (V,) or a number.
        Returns (V, 3).
        """
        gaps = moved[self.pairs[:, 0]] - moved[self.pairs[:, 1]]
        slack = _SLACK * np.abs(gaps).max(initial=0.0)
        active = conditions.broken(gaps, slack)
        if not conditions.closed.any() and not active.any():
            return moved
        always = 3 * conditions.closed.sum()
        for _ in range(ROUNDS):
            which, directions, values = conditions.rows(active)
            forces = self._forces(which, directions, values - (directions * gaps[which]).sum(1))
            pulls = np.zeros((len(self.pairs), 3))
            np.add.at(pulls, which, forces[:, None] * directions)
            released = np.zeros(len(active), dtype=bool)
            released[np.flatnonzero(active)[forces[always:] < 0]] = True
            violated = ~active & conditions.broken(gaps + self.compliance @ pulls, slack)
            if not released.any() and not violated.any():
                break
            active = (active & ~released) | violated
        return self._corrected(moved, pulls, np.broadcast_to(share, len(moved)))

    def _forces(self, which: np.ndarray, directions: np.ndarray, missing: np.ndarray) -> np.ndarray:
        """Forces (R,) on pairs (R,) along directions (R, 3) that make up for what is missing (R,)."""
        system = (directions @ directions.T) * self.compliance[np.ix_(which, which)]
        return np.linalg.solve(system + self.softness * np.eye(len(which)), missing)

    def _corrected(self, moved: np.ndarray, pulls: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Displacements (V, 3) after pairs were pulled apart (P, 3); vertices take their share (V,)."""
        pulling = np.flatnonzero(pulls.any(axis=1))
        corrected = np.array(moved)
        takes = np.flatnonzero((share != 0) & (self.rows >= 0))
        answer = self.responses[np.ix_(pulling, self.rows[takes])].T @ pulls[pulling]
        corrected[takes] += share[takes, None] * answer
        return corrected
