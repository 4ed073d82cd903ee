"""The names of the 52 facial actions of ARKit, which every engine's face tracking speaks, and what they start from."""

from collections.abc import Sequence

import numpy as np

ARKIT_NAMES = tuple(
    "eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft eyeWideLeft "
    "eyeBlinkRight eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight eyeSquintRight eyeWideRight "
    "jawForward jawRight jawLeft jawOpen mouthClose mouthFunnel mouthPucker mouthRight mouthLeft mouthSmileLeft "
    "mouthSmileRight mouthFrownLeft mouthFrownRight mouthDimpleLeft mouthDimpleRight mouthStretchLeft "
    "mouthStretchRight mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper mouthPressLeft mouthPressRight "
    "mouthLowerDownLeft mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight browDownLeft browDownRight browInnerUp "
    "browOuterUpLeft browOuterUpRight cheekPuff cheekSquintLeft cheekSquintRight noseSneerLeft noseSneerRight "
    "tongueOut".split()
)
"""In ARKit's spelling and the order of Live Link Face's columns, which write the first letter as a capital."""

STARTS = {"mouthClose": "jawOpen"}
"""Actions that only mean something on top of others: mouthClose closes the lips while the jaw is open."""


def start_delta(names: Sequence[str], deltas: np.ndarray, k: int) -> np.ndarray:
    """What expression k is added to besides the neutral face: the displacements (V, 3) of another one, or zeros.

    names: (K,) of expressions. deltas: (K, V, 3) of each alone.
    """
    base = STARTS.get(names[k])
    return deltas[names.index(base)] if base in names else np.zeros_like(deltas[k])
