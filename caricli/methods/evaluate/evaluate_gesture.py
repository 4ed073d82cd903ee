"""How often strokes are taken for the gestures that they are."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.evaluate.gesture_strangers import strange_gesture, strange_other
from caricli.models.gesture.model import GestureModel, recognition
from caricli.structures.gesture import GESTURES

DOUBTFUL = "doubtful"
OTHER = "no gesture"
UNDO = "left_arrow"


@dataclass(frozen=True, eq=False)
class GestureFigures:
    """What an evaluation comes to.

    counts: by what strokes are (GESTURES, and OTHER for strokes that are none), by what they are taken for (GESTURES
    and DOUBTFUL), how many. likeliest: percent of gestures whose likeliest name is right, doubtful ones among them.
    """

    counts: dict[str, dict[str, int]]
    likeliest: float

    @property
    def right(self) -> float:
        """Percent of gestures that are taken for what they are."""
        return 100 * sum(self.counts[name][name] for name in GESTURES) / self._drawn

    @property
    def doubtful(self) -> float:
        """Percent of gestures that the page asks about."""
        return 100 * sum(self.counts[name][DOUBTFUL] for name in GESTURES) / self._drawn

    @property
    def wrong_undo(self) -> float:
        """Percent of gestures other than undo that are taken for it."""
        others = [name for name in GESTURES if name != UNDO]
        return 100 * sum(self.counts[name][UNDO] for name in others) / sum(self._row(name) for name in others)

    @property
    def other_doubtful(self) -> float:
        """Percent of strokes that are no gesture and are taken for none."""
        return 100 * self.counts[OTHER][DOUBTFUL] / self._row(OTHER)

    @property
    def other_undo(self) -> float:
        """Percent of strokes that are no gesture and are taken for undo."""
        return 100 * self.counts[OTHER][UNDO] / self._row(OTHER)

    @property
    def _drawn(self) -> int:
        return sum(self._row(name) for name in GESTURES)

    def _row(self, name: str) -> int:
        return sum(self.counts[name].values())

    def as_json(self) -> dict:
        """What reports say of it: percentages, and the confusion matrix."""
        names = ("right", "doubtful", "likeliest", "wrong_undo", "other_doubtful", "other_undo")
        return {name: getattr(self, name) for name in names} | {"confusion": self.counts}


def evaluate_gesture(model: GestureModel, count: int, seed: int = 0) -> GestureFigures:
    """Let a model tell strokes of hands that no training saw.

    model: GestureModel. count: strokes of each gesture, and as many that are none. seed: of the strokes.
    """
    counts = {}
    likeliest = 0
    for number, name in enumerate((*GESTURES, OTHER)):
        hands = (np.random.default_rng([seed, number, row]) for row in range(count))
        strokes = [strange_other(hand) if name == OTHER else strange_gesture(name, hand) for hand in hands]
        seen = [recognition(row) for row in model.probabilities(strokes)]
        taken = [each.name or DOUBTFUL for each in seen]
        counts[name] = {as_what: taken.count(as_what) for as_what in (*GESTURES, DOUBTFUL)}
        likeliest += sum(each.likeliest == name for each in seen)
    return GestureFigures(counts, 100 * likeliest / (count * len(GESTURES)))
