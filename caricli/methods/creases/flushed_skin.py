"""What expressions do to the colour of skin and lips: flush, and lips that pale where they are stretched."""

from collections.abc import Mapping, Sequence

import numpy as np

from caricli.data.albedo import BLOOD, AlbedoPainter
from caricli.geometry.smooth_step import smooth_step
from caricli.structures.landmarks import LOWER_LID, POINT_NAMES

_EFFORT = {"browDown": 0.3, "noseSneer": 0.35, "cheekPuff": 0.7, "mouthSmile": 0.25, "jawOpen": 0.25, "mouthFrown": 0.2,
           "eyeSquint": 0.2}  # fmt: skip
"""What makes blood rise, by actions, both sides together."""
_STRETCH = {"mouthStretch": 0.6, "mouthSmile": 0.5, "mouthPress": 0.7, "jawOpen": 0.35, "mouthRoll": 0.8,
            "mouthUpperUp": 0.2}  # fmt: skip
_GATHER = {"mouthPucker": 1.0, "mouthFunnel": 0.6, "mouthShrugLower": 0.2}
_BLOOD = 0.35  # most that a flush adds
_PALE = 0.3  # most blood that leaves stretched lips
_FULL = 0.15  # most that gathered lips are darker, of logarithms


class FlushedSkin:
    """Where skin reddens and lips are, for all people of a topology."""

    def __init__(self, painter: AlbedoPainter) -> None:
        """painter: AlbedoPainter of the places."""
        marks = painter.marks
        nose = marks[POINT_NAMES["nose_tip"]]
        cheeks = [0.5 * (marks[LOWER_LID[side][2]] + marks[POINT_NAMES[f"mouth_corner_{side}"]]) + [out * 0.08, 0, 0]
                  for side, out in (("right", -1), ("left", 1))]  # fmt: skip
        self.area = np.zeros(len(painter.places))
        for centre, radius, share in ((nose, 0.2, 0.7), (cheeks[0], 0.3, 1.0), (cheeks[1], 0.3, 1.0)):
            self.area += share * np.exp(-((np.linalg.norm(painter.places - centre, axis=1) / radius) ** 2))
        # The rest of the face goes along a little.
        self.area = np.minimum(self.area + 0.2 * smooth_step(painter.places[:, 2], -0.7, -0.2), 1)
        self.lips = smooth_step(painter.lips, 0.03, -0.03)
        self.area *= 1 - self.lips

    def factors(self, weights: Mapping[str, float], flush: float) -> np.ndarray:
        """(P, 3) of linear colours, by weights of actions. flush: how easily a person reddens, 0 to 1."""
        blood = _BLOOD * flush * _sum(weights, _EFFORT) * self.area - _PALE * _sum(weights, _STRETCH) * self.lips
        dark = _FULL * _sum(weights, _GATHER) * self.lips
        return np.exp(-np.multiply.outer(blood, BLOOD) - dark[:, None])


def _sum(weights: Mapping[str, float], table: Mapping[str, float]) -> float:
    """From 0 to 1, by actions of either side and of none."""
    total = 0.0
    for name, share in table.items():
        own: Sequence[float] = [weight for action, weight in weights.items() if action.startswith(name)]
        both = [action for action in weights if action.startswith(name) and action.endswith(("Left", "Right"))]
        total += share * sum(own) / (2 if both else 1)
    return float(np.clip(total, 0, 1))
