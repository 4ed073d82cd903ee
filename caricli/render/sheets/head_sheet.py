"""A picture, and the head that was made of it."""

import numpy as np

from caricli.render.rig_stage import RigStage
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.crop_portrait import crop_portrait
from caricli.structures import Rig

_VIEWS = ("front", "three-quarter")
"""Of the head as it was drawn."""

_MOODS = {
    "glad": {"mouthSmile": 0.8, "cheekSquint": 0.5, "eyeSquint": 0.4},
    "surprised": {"browInnerUp": 1.0, "browOuterUp": 1.0, "eyeWide": 1.0, "jawOpen": 0.7},
    "asleep": {"eyeBlink": 1.0},
    "cross": {"browDown": 1.0, "mouthFrown": 1.0, "noseSneer": 0.6},
}
"""Weights of ARKit's expressions, or of those of both sides."""


def head_sheet(picture: np.ndarray, points: np.ndarray, drawn: Rig, rig: Rig, size: int) -> np.ndarray:
    """A row of the face in its picture, the head as it was drawn, and some moods of it.

    picture: (H, W, 3) uint8. points: (L, 2) pixels, landmarks in it, NaN where unknown. drawn: Rig of the head with the
    expression of the picture, and rig: Rig of it with expressions. size: pixels of each. Returns (H, W, 3) uint8.
    """
    heads = [RigStage(drawn, view, size).picture(drawn.neutral) for view in _VIEWS]
    moods = RigStage(rig, "front", size).pictures(_shape(rig, weights) for weights in _MOODS.values())
    return contact_sheet([crop_portrait(picture, points, size), *heads, *moods], 1 + len(_VIEWS) + len(_MOODS))


def _shape(rig: Rig, weights: dict[str, float]) -> np.ndarray:
    """(V, 3) the rig with the expressions of these names, left and right."""
    ways = {name: weight for base, weight in weights.items() for name in (base, f"{base}Left", f"{base}Right")}
    return rig.neutral + sum(ways[name] * rig.deltas[k] for k, name in enumerate(rig.names) if name in ways)
