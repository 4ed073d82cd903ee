"""What is said of networks."""

from functools import singledispatch

from torch import nn

from caricli.methods.inspect.inspection import Acquaintances, Inspection
from caricli.models.coarse.model import CoarseModel
from caricli.models.gesture.model import GestureModel
from caricli.models.network_model import NetworkModel
from caricli.models.sketch.model import SketchModel
from caricli.models.strokes.model import StrokeModel
from caricli.models.style.model import StyleModel
from caricli.models.texture.model import TextureModel
from caricli.structures.gesture import GESTURES


@singledispatch
def describe_network(value: NetworkModel, around: Acquaintances) -> Inspection:
    """What is said of a network. Each kind has words of its own."""
    raise NotImplementedError(value.kind)


@describe_network.register
def _(value: CoarseModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    summary = f"{weights / 1e6:.1f} million weights, for faces in windows of {value.size} pixels"
    lines = (f"coefficients: {value.network.outputs}, of {around.model_name(value.basis)}",)
    figures = {"weights": weights, "size": value.size, "model_id": value.model_id, "basis": value.basis}
    return Inspection("coarse network", summary, lines, figures)


@describe_network.register
def _(value: SketchModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    summary = f"{weights / 1e6:.1f} million weights, for sketches in windows of {value.size} pixels"
    lines = (f"latents: {value.network.dimension}, of {around.model_name(value.basis)}", ", ".join(value.curves))
    figures = {"weights": weights, "size": value.size, "model_id": value.model_id, "basis": value.basis}
    return Inspection("sketch network", summary, lines, figures | {"curves": list(value.curves)})


@describe_network.register
def _(value: StrokeModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    summary = f"{weights / 1e6:.1f} million weights, for strokes in windows of {value.window} pixels"
    figures = {"weights": weights, "size": value.window, "model_id": value.model_id, "curves": list(value.curves)}
    return Inspection("stroke network", summary, (", ".join(value.curves),), figures)


@describe_network.register
def _(value: GestureModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    summary = f"{weights / 1e6:.1f} million weights, for strokes in pictures of {value.network.size} pixels"
    figures = {"weights": weights, "size": value.network.size, "model_id": value.model_id}
    return Inspection("gesture network", summary, (", ".join(GESTURES),), figures)


@describe_network.register
def _(value: StyleModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    figures = {"weights": weights, "model_id": value.model_id, "media": list(value.media)}
    return Inspection("style network", f"{weights / 1e6:.1f} million weights", (", ".join(value.media),), figures)


@describe_network.register
def _(value: TextureModel, around: Acquaintances) -> Inspection:
    weights = _weights(value.network)
    summary = f"{weights / 1e6:.1f} million weights, for textures in charts of {value.size} texels"
    figures = {"weights": weights, "size": value.size, "model_id": value.model_id, "topology_id": value.topology_id}
    return Inspection("texture network", summary, (), figures)


def _weights(network: nn.Module) -> int:
    """How many numbers a network has learned."""
    return sum(parameter.numel() for parameter in network.parameters())
