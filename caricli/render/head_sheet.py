"""A picture, and the head that was made of it."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.crop_portrait import crop_portrait
from caricli.render.rig_stage import RigStage
from caricli.structures import Rig

_REST = "three-quarter"
_MOODS = {
    "glad": {"mouthSmile": 0.8, "cheekSquint": 0.5, "eyeSquint": 0.4},
    "surprised": {"browInnerUp": 1.0, "browOuterUp": 1.0, "eyeWide": 1.0, "jawOpen": 0.7},
    "asleep": {"eyeBlink": 1.0},
    "cross": {"browDown": 1.0, "mouthFrown": 1.0, "noseSneer": 0.6},
}
"""Weights of ARKit's expressions, or of those of both sides."""


def head_sheet(picture: np.ndarray, points: np.ndarray, rig: Rig, size: int) -> np.ndarray:
    """A row of the face in its picture, the head at rest from one side, and some moods of it.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, landmarks in it, NaN where unknown. rig: Rig. size: pixels of each.
    Returns (H, W, 3) uint8.
    """
    rest = RigStage(rig, _REST, size).picture(rig.neutral)
    moods = RigStage(rig, "front", size).pictures(_shape(rig, weights) for weights in _MOODS.values())
    return contact_sheet([crop_portrait(picture, points, size), rest, *moods], 2 + len(_MOODS))


def _shape(rig: Rig, weights: dict[str, float]) -> np.ndarray:
    """(V, 3) the rig with the expressions of these names, left and right."""
    ways = {name: weight for base, weight in weights.items() for name in (base, f"{base}Left", f"{base}Right")}
    return rig.neutral + sum(ways[name] * rig.deltas[k] for k, name in enumerate(rig.names) if name in ways)
