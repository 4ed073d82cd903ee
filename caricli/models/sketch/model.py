"""The network that sees faces in sketches, as it is used."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming, shown
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.models.checks import check_schema, curve_names, network_size, whole_number, window_side
from caricli.models.inference import on_one_core
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.models.sketch.config import STEP, PublishedSize, SketchSize
from caricli.models.sketch.networks import SketchNetwork
from caricli.models.sketch.published import PublishedNetwork
from caricli.models.sketch.window import CANVAS_FILL, FILL, POINTS, Window, curve_points, shown_strokes
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.structures import Camera
from caricli.structures.sketch import Sketch

SCHEMA = "caricli.sketch_network/1"

THICKEST = 3.4
"""Pixels of a window: the widest of the lines that networks are trained with."""

_SIDES = (64, 512)
_OUTPUTS = (1, 10**4)


class SketchModel(NetworkModel[SketchNetwork | PublishedNetwork]):
    """Tells the latent of the face of a sketch, and the camera that sees it as it is drawn."""

    kind = "sketch"

    def __init__(
        self,
        network: SketchNetwork | PublishedNetwork,
        size: int,
        curves: tuple[str, ...],
        basis: str,
        recipe: Any = None,
    ) -> None:
        """network: weights. size: of its windows, pixels. curves: K names of what it knows strokes by. basis:
        ``model_id`` of the shape model whose latents it tells. recipe: JSON value, how it was trained, or None.
        """
        super().__init__(network, recipe)
        self.size = size
        self.curves = curves
        self.basis = basis

    @property
    def label(self) -> str:
        """What tables call it."""
        return self.network.variant.label if isinstance(self.network, PublishedNetwork) else "network"

    @property
    def held_out(self) -> tuple[float, int] | None:
        """The share of faces that its training held out, and the seed of their choice; None where nothing is said."""
        config = self.recipe.get("config") if isinstance(self.recipe, dict) else None
        if not isinstance(config, dict):
            return None
        share = config.get("held")
        seed = config.get("seed")
        if not isinstance(share, int | float) or not isinstance(seed, int) or not 0 <= share <= 1 or seed < 0:
            return None
        return share, seed

    @property
    def on_canvas(self) -> bool:
        """Whether it expects heads to stand where heads usually do, as published networks do, at their usual size."""
        return isinstance(self.network, PublishedNetwork)

    @property
    def wrinkled(self) -> bool:
        """Whether it looks at wrinkle lines."""
        return isinstance(self.network, PublishedNetwork) and self.network.variant.wrinkles

    def look(self, sketch: Sketch) -> tuple[np.ndarray, np.ndarray, Window]:
        """What ``read`` is given of a sketch: ink (S, S) uint8 and points (K, P, 2), and the Window that both are in.

        Strokes whose names are curves of the model say where these are; all others are only seen, wrinkles by networks
        that look at them. Raises InputError where nothing is drawn.
        """
        strokes = shown_strokes(sketch, self.curves)
        window = Window.around([stroke.points for stroke in strokes], max(sketch.size))
        if self.on_canvas:
            # How large the head is meant to be nothing tells.
            window = Window(window.centre, window.half * FILL / CANVAS_FILL)
        if self.wrinkled:
            strokes = list(sketch.strokes)
        points = curve_points(strokes, window, self.curves, self.network.usual.double().numpy())
        return window_picture(sketch.with_strokes(strokes), window, self.size), points, window

    def mirrored(self, points: np.ndarray) -> np.ndarray:
        """Points (B, K, P, 2) of lines as those of their mirror image.

        What is drawn of a curve on the left is of that on the right, and its points run as those of this one do.
        """
        usual = self.network.usual.double().numpy()
        names = [other_side(name) for name in self.curves]
        there = np.array([name in self.curves for name in names])
        other = [self.curves.index(name) if name in self.curves else 0 for name in names]
        turned = np.where(there[:, None, None], points[:, other] * [-1, 1], np.nan)
        ways = usual[other] * [-1, 1]
        centred = usual - usual.mean(1, keepdims=True)
        back = (centred * ways).sum((1, 2)) < (centred * ways[:, ::-1]).sum((1, 2))
        return np.where(back[:, None, None], turned[:, :, ::-1], turned)

    @on_one_core
    def read(self, windows: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Latents and cameras (B, D + 6) of windows (B, S, S) uint8 ink, and points (B, K, P, 2), NaN where unknown."""
        ink = torch.from_numpy(windows.astype(np.float32) / 255)[:, None]
        return self.network(ink, torch.from_numpy(points.astype(np.float32))).double().numpy()


def other_side(name: str) -> str:
    """Of a curve on one side the name of that on the other; itself in the middle."""
    for own, other in (("left", "right"), ("right", "left")):
        if name.endswith(f"_{own}"):
            return name.removesuffix(own) + other
    return name


def window_picture(sketch: Sketch, window: Window, size: int) -> np.ndarray:
    """The strokes in a window as a picture (S, S) uint8, 255 where ink is; none thicker than networks are shown."""
    scale = (size - 1) / 2
    strokes = []
    for stroke in sketch.strokes:
        width = None if stroke.width is None else min(stroke.width * scale / window.half, THICKEST)
        strokes.append(replace(stroke, points=scale * (1 + window.inside(stroke.points)), width=width))
    return rasterise_sketch(Sketch(tuple(strokes), (size, size)), size)


def window_camera(numbers: np.ndarray, window: Window) -> Camera:
    """The camera of six numbers, see ``CAMERA``, in pixels of the canvas."""
    scale = float(np.exp(numbers[3])) * window.half
    return Camera(scale, head_rotation(numbers[:3]), window.half * numbers[4:] + window.centre)


def sketch_to_checkpoint(model: SketchModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``sketch_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(model.network.size), "dimension": model.network.dimension}
    about |= {"size": model.size, "curves": list(model.curves), "basis": model.basis}
    return model.tensors(), about | {"recipe": model.recipe}


def sketch_from_checkpoint(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object
) -> SketchModel:
    """Rebuild a SketchModel.

    tensors, metadata: of ``sketch_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "sketch network")
        size = window_side(metadata.get("size"), _SIDES, STEP)
        dimension = whole_number(metadata.get("dimension"), _OUTPUTS, "dimension")
        curves = curve_names(metadata.get("curves"))
        basis = metadata.get("basis")
        if not isinstance(basis, str):
            raise InputError(f"expected the shape model that it belongs to, found {shown(basis, 60)!r}")
        network = load_network(partial(_network, metadata.get("network"), size, dimension, len(curves)), tensors)
        return SketchModel(network, size, curves, basis, metadata.get("recipe"))


def _network(about: Any, size: int, dimension: int, curves: int) -> SketchNetwork | PublishedNetwork:
    """A network without weights. about: of the file."""
    generator = torch.Generator()
    if not isinstance(about, dict) or "variant" not in about:
        return SketchNetwork(network_size(about, SketchSize), curves, POINTS, dimension, generator)
    published = network_size(about, PublishedSize)
    if dimension != published.identity + published.expression - 1:
        raise InputError(f"expected a published network of {dimension} numbers, found {shown(about, 60)!r}")
    return PublishedNetwork(published, curves, POINTS, size, generator)
