"""The network that tells what strokes draw, as it is used."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming
from caricli.models.checks import check_schema, curve_names, network_size, window_side
from caricli.models.inference import on_one_core
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.models.sketch.model import other_side
from caricli.models.sketch.window import Window
from caricli.models.strokes.config import STEP, StrokeSize
from caricli.models.strokes.networks import StrokeNetwork
from caricli.models.strokes.places import Places, line_picture
from caricli.structures.sketch import Sketch

SCHEMA = "caricli.strokes/1"

_SIDES = (64, 512)


@dataclass(frozen=True, eq=False)
class StrokeReading:
    """What places along strokes draw.

    places: Places. chances: (N, C) of each curve, from 0 to 1; the rest up to 1 is the chance that it is none of them.
    curves: C names.
    """

    places: Places
    chances: np.ndarray
    curves: tuple[str, ...]


class StrokeModel(NetworkModel[StrokeNetwork]):
    """Tells which curve of a face strokes draw at each place along them."""

    kind = "strokes"

    def __init__(self, network: StrokeNetwork, window: int, curves: tuple[str, ...], recipe: Any = None) -> None:
        """network: weights, of one class more than there are curves. window: its side, pixels. curves: C names.

        recipe: JSON value, how it was trained, or None.
        """
        super().__init__(network, recipe)
        self.window = window
        self.curves = curves

    @on_one_core
    def read(self, sketch: Sketch) -> StrokeReading:
        """What the strokes of a sketch draw, whatever their names say. Raises InputError where nothing is drawn,
        or the network's numbers overflow.

        Chances are the means of those of the lines and of their mirror image, so that this says the same of both.
        """
        lines = [stroke.points for stroke in sketch.strokes]
        window = Window.around(lines, max(sketch.size))
        places = Places.of(lines, window)
        ink = torch.from_numpy(line_picture(lines, window, self.window).astype(np.float32) / 255)[None, None]
        about = torch.from_numpy(places.about)[None]
        own = self.network(ink, about).softmax(2)[0]
        turned = self.network(ink.flip(3), about * torch.tensor([-1.0, 1, 1, -1])).softmax(2)[0]
        chances = (own + turned[:, self._turned]) / 2
        if not chances.isfinite().all():
            raise InputError("expected a stroke network that tells chances, found one whose numbers overflow")
        return StrokeReading(places, chances[:, 1:].double().numpy(), self.curves)

    @property
    def _turned(self) -> list[int]:
        """Of every class the one that it is in a mirror."""
        numbers = {name: 1 + number for number, name in enumerate(self.curves)}
        return [0, *(numbers.get(other_side(name), numbers[name]) for name in self.curves)]


def strokes_to_checkpoint(model: StrokeModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``strokes_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(model.network.size), "size": model.window}
    return model.tensors(), about | {"curves": list(model.curves), "recipe": model.recipe}


def strokes_from_checkpoint(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object
) -> StrokeModel:
    """Rebuild a StrokeModel.

    tensors, metadata: of ``strokes_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "stroke network")
        window = window_side(metadata.get("size"), _SIDES, STEP)
        curves = curve_names(metadata.get("curves"))
        size = network_size(metadata.get("network"), StrokeSize)
        network = load_network(partial(StrokeNetwork, size, 1 + len(curves), torch.Generator()), tensors)
        return StrokeModel(network, window, curves, metadata.get("recipe"))
