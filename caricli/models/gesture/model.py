"""The gesture network as it is used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming, shown
from caricli.models.checks import check_schema, whole_number, window_side
from caricli.models.gesture.config import POOLED
from caricli.models.gesture.networks import GestureNetwork
from caricli.models.inference import on_one_core
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.render.pixels.draw_stroke import draw_stroke
from caricli.structures.gesture import GESTURES

SCHEMA = "caricli.gesture/1"

SURE = 0.4
"""Probability from which on a stroke is a gesture, and not one to ask about."""
SURE_ARROW = 0.9
"""The same of arrows: what was not meant for undo must not undo."""

_SIZES = (16, 512)
_STRIDES = (1, 8)
_AT_ONCE = 256


@dataclass(frozen=True)
class Recognition:
    """What a stroke is.

    name: one of GESTURES, or None where it is doubtful. likeliest: one of GESTURES in any case. probability: of it.
    """

    name: str | None
    likeliest: str
    probability: float


class GestureModel(NetworkModel[GestureNetwork]):
    """Tells gestures apart by the pictures of their strokes."""

    kind = "gesture"

    def recognise(self, stroke: np.ndarray) -> Recognition:
        """What a stroke (N, 2), pixels, y down, is. Raises InputError when it is no line."""
        return recognition(self.probabilities([stroke])[0])

    @on_one_core
    def probabilities(self, strokes: Sequence[np.ndarray]) -> np.ndarray:
        """(B, 10) of GESTURES. strokes: (N, 2) each, pixels, y down. Raises InputError when one is no line."""
        parts = [np.zeros((0, len(GESTURES)), np.float32)]
        for start in range(0, len(strokes), _AT_ONCE):
            pictures = np.stack([self._picture(each) for each in strokes[start : start + _AT_ONCE]])
            values = torch.from_numpy(pictures[:, None].astype(np.float32) / 255)
            parts.append(self.network(values).softmax(1).numpy())
        return np.concatenate(parts)

    def _picture(self, stroke: np.ndarray) -> np.ndarray:
        points = np.asarray(stroke, np.float64)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
            raise InputError(f"expected a stroke of two points or more, found {points.shape}")
        if not np.ptp(points, axis=0).any():
            raise InputError("expected a stroke of some length, found a dot")
        return draw_stroke(points, self.network.size)


def recognition(probabilities: np.ndarray) -> Recognition:
    """What a stroke with these probabilities (10,) is."""
    best = int(probabilities.argmax())
    name = GESTURES[best]
    sure = SURE_ARROW if name.endswith("_arrow") else SURE
    probability = float(probabilities[best])
    return Recognition(name if probability >= sure else None, name, probability)


def gesture_to_checkpoint(model: GestureModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``gesture_from_checkpoint`` rebuilds it."""
    own = model.network
    about = {"schema": SCHEMA, "size": own.size, "stride": own.stride, "gestures": list(GESTURES)}
    return model.tensors(), about | {"recipe": model.recipe}


def gesture_from_checkpoint(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object
) -> GestureModel:
    """Rebuild a GestureModel.

    tensors, metadata: of ``gesture_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "gesture network")
        if metadata.get("gestures") != list(GESTURES):
            raise InputError(f"expected the gestures of this version, found {shown(metadata.get('gestures'), 60)!r}")
        stride = whole_number(metadata.get("stride"), _STRIDES, "stride")
        size = window_side(metadata.get("size"), _SIZES, POOLED * stride)
        network = load_network(partial(GestureNetwork, size, stride, len(GESTURES), torch.Generator()), tensors)
        return GestureModel(network, metadata.get("recipe"))
