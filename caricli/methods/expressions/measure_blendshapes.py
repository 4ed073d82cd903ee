"""How well a caricature's expressions keep who it is and show what they are (expressions paper, section 4.2.1)."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.expressions.optimise_blendshapes import UNMOVED, cosines, displacement_masks

CLEAR = 0.5
"""From this share of an expression's largest displacement on, a vertex shows it."""


@dataclass(frozen=True, eq=False)
class BlendshapeMeasures:
    """What was measured of K expressions; NaN for one that does nothing.

    drift: (K,) metres, mean displacement where the normal face hardly moves: a change of identity.
    strength: (K,) mean displacement where the normal face moves clearly, of the normal face's.
    excess: (K,) how much farther vertices go than those of the normal face, on average, of its mean displacement.
    structure: mean difference of the cosines between expressions from those of the normal face.
    """

    drift: np.ndarray
    strength: np.ndarray
    excess: np.ndarray
    structure: float


def measure_blendshapes(moves: np.ndarray, normal: np.ndarray) -> BlendshapeMeasures:
    """Compare displacements of a caricature with those of a normal face. moves, normal: (K, V, 3), metres."""
    shares = displacement_masks(normal)
    own = np.linalg.norm(moves, axis=2)
    usual = np.linalg.norm(normal, axis=2)
    still = shares < UNMOVED
    clear = shares > CLEAR
    acts = usual.any(axis=1)

    def mean(values: np.ndarray, where: np.ndarray) -> np.ndarray:
        return np.where(acts, (values * where).sum(1) / np.maximum(where.sum(1), 1), np.nan)

    with np.errstate(invalid="ignore", divide="ignore"):
        strength = mean(own, clear) / mean(usual, clear)
        excess = np.where(acts, np.maximum(own - usual, 0).mean(1) / usual.mean(1), np.nan)
    gaps = np.abs(cosines(moves[acts]) - cosines(normal[acts]))
    pairs = max(acts.sum() * (acts.sum() - 1), 1)
    return BlendshapeMeasures(mean(own, still), strength, excess, float(gaps.sum() / pairs))
