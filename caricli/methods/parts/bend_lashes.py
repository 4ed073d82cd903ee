"""Lashes bent out of skin."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from caricli.methods.parts.flesh import Flesh


@dataclass(frozen=True)
class BendSettings:
    """How lashes make way for lids.

    sunk: share of the head's height that a lash may be in the skin at its root; towards its tip it is less, there
    nothing. aim: of that, how deep they are where they were deeper. together: share of the height, how near to each
    other lashes bend together. rounds: bends, at most; alone: so many of them, the last, each lash for itself. shift,
    bend: weights against moving a root and against bending a lash, to one vertex of it that is as deep. shorter: factor
    of the length of a lash that even then goes through a fold, cuts times at most.
    """

    sunk: float = 0.002
    aim: float = 0.8
    together: float = 0.01
    rounds: int = 10
    shift: float = 1.0
    bend: float = 0.05
    alone: int = 4
    shorter: float = 0.7
    cuts: int = 4


class Lashes:
    """Vertices of lashes, each of which may be bent around its root."""

    def __init__(
        self,
        shape: np.ndarray,
        labels: np.ndarray,
        roots: np.ndarray,
        height: float,
        settings: BendSettings = BendSettings(),  # noqa: B008 (frozen)
    ) -> None:
        """shape: (W, 3) metres. labels: (W,) the lash of every vertex. roots: (L,) vertices. height: of the head."""
        self.labels = labels
        self.roots = roots
        self.height = height
        self.settings = settings
        away = shape - shape[roots][labels]
        self.lengths = _lengths(away, labels)
        self.share = np.linalg.norm(away, axis=1) / self.lengths[labels]
        apart = np.linalg.norm(shape[roots][:, None] - shape[roots], axis=-1)
        self.near = np.exp(-0.5 * (apart / (settings.together * height)) ** 2)

    def shortened(self, shape: np.ndarray, size: float) -> np.ndarray:
        """Lashes (W, 3) that are no longer than those of usual eyes on a head of a size: drawn eyes are often huge."""
        roots = shape[self.roots][self.labels]
        away = shape - roots
        return roots + away / np.maximum(_lengths(away, self.labels) / self.lengths / size, 1.0)[self.labels, None]

    def bent(
        self,
        flesh: Mapping[float, Flesh],
        start: np.ndarray,
        end: np.ndarray,
        size: float,
        asked: np.ndarray | None = None,
    ) -> np.ndarray:
        """Where lashes end (W, 3) so that skin covers them nowhere on the straight way from their start.

        Every round minimises ``sum |change of a vertex along its way out - way out|^2`` for each lash, with weights
        against bends and moves of its root, and shares what comes of it with the lashes beside it. Lashes that are
        still deeper than roots may be after all rounds are shortened.

        flesh: by shares of the way. start, end: (W, 3) metres. size: of the head, to the usual one. asked: (L,) bool,
        the lashes that may be covered.
        """
        shifts = np.zeros((len(self.roots), 2, 3))
        bent = end
        ids = np.arange(len(start)) if asked is None else np.flatnonzero(asked[self.labels])
        for left in reversed(range(self.settings.rounds)):
            step = self._step(flesh, start, bent - start, size, ids) if len(ids) else None
            if step is None:
                return bent
            # Of a lash beside others that are not covered, all; of one among covered ones, the mean.
            covered = step.any((1, 2))
            near = self.near if left >= self.settings.alone else np.eye(len(self.roots))
            step = (near @ step.reshape(-1, 6) / np.maximum(near @ covered, 1)[:, None]).reshape(step.shape)
            shifts += step
            bent = self._turned(end, shifts)
            ids = np.flatnonzero(
                (np.abs(step).max((1, 2)) > 1e-3 * self.settings.sunk * size * self.height)[self.labels]
            )
        return self._cut(flesh, start, bent, size, ids)

    def _cut(
        self, flesh: Mapping[float, Flesh], start: np.ndarray, end: np.ndarray, size: float, ids: np.ndarray
    ) -> np.ndarray:
        """Ends (W, 3) of lashes with those shortened of which vertices ids are deeper on the way than roots may be."""
        end = end.copy()
        allowed = self.settings.sunk * size * self.height
        for _ in range(self.settings.cuts):
            deep = np.zeros(len(ids), bool)
            for share, skin in flesh.items():
                places = start[ids] + share * (end[ids] - start[ids])
                deep |= skin.ways_out(places, np.full(len(ids), allowed)).any(1)
            if not deep.any():
                break
            ids = np.flatnonzero(np.isin(self.labels, self.labels[ids[deep]]))
            roots = end[self.roots][self.labels[ids]]
            end[ids] = roots + self.settings.shorter * (end[ids] - roots)
        return end

    def _step(
        self, flesh: Mapping[float, Flesh], start: np.ndarray, way: np.ndarray, size: float, ids: np.ndarray
    ) -> np.ndarray | None:
        """(L, 2, 3) changes of the shifts of roots and tips for each lash itself, None where no vertex is too deep."""
        settings = self.settings
        system = np.tile(np.diag(np.repeat([settings.shift, settings.bend], 3)), (len(self.roots), 1, 1))
        aims = np.zeros((len(self.roots), 6))
        allowed = settings.sunk * size * self.height * (1 - self.share)
        for share, skin in flesh.items():
            out = skin.ways_out(start[ids] + share * way[ids], allowed[ids])
            depth = np.linalg.norm(out, axis=1)
            deep = depth > 0
            vertices = ids[deep]
            ways = share * out[deep] / depth[deep, None]
            rows = np.concatenate([ways, self.share[vertices, None] * ways], axis=1)
            lacks = depth[deep] - settings.aim * allowed[vertices]
            np.add.at(system, self.labels[vertices], rows[:, :, None] * rows[:, None])
            np.add.at(aims, self.labels[vertices], rows * lacks[:, None])
        if not aims.any():
            return None
        return np.linalg.solve(system, aims[..., None]).reshape(-1, 2, 3)

    def _turned(self, shape: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Lashes (W, 3) whose roots and, besides, tips are shifted by (L, 2, 3), none of them longer than before."""
        roots = shape[self.roots][self.labels]
        away = shape - roots
        turned = away + self.share[:, None] * shifts[self.labels, 1]
        before, after = (np.linalg.norm(ways, axis=1) for ways in (away, turned))
        kept = np.minimum(before / np.maximum(after, 1e-12), 1.0)
        return roots + shifts[self.labels, 0] + kept[:, None] * turned


def _lengths(away: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """(L,) how far the farthest vertex of every lash is from its root. away: (W, 3) from there. labels: (W,)."""
    lengths = np.zeros(labels.max() + 1)
    np.maximum.at(lengths, labels, np.linalg.norm(away, axis=1))
    return lengths
