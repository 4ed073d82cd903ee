"""The style network as it is used."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from caricli.errors import InputError, naming, shown
from caricli.models.checks import check_schema, whole_number
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.models.style.config import STEP
from caricli.models.style.networks import Statistics, StyleNetwork, renormalised, statistics

SCHEMA = "caricli.style/1"
STEEPEST = 2.5
"""How many times as strong as it was a feature may vary: smooth skin would otherwise become all blotches."""

_WIDTHS = (4, 256)
_MEDIA = (1, 100)


@dataclass(frozen=True, eq=False)
class Look:
    """What is taken from a style picture: statistics of its features at full, half and quarter size."""

    levels: tuple[Statistics, ...]


class StyleModel(NetworkModel[StyleNetwork]):
    """Lends pictures the look of others."""

    kind = "style"

    def __init__(self, network: StyleNetwork, media: tuple[str, ...], recipe: Any = None) -> None:
        """network: weights. media: names of those that it was trained on. recipe: JSON value, how it was trained."""
        super().__init__(network, recipe)
        self.media = media

    @torch.inference_mode()
    def look(self, picture: np.ndarray) -> Look:
        """The Look of a picture (H, W, 3) uint8."""
        return Look(tuple(statistics(level) for level in self.network.encoder(_tensor(picture[None]))))

    @torch.inference_mode()
    def lend(self, pictures: np.ndarray, look: Look, strength: float = 1.0, seed: int = 0) -> np.ndarray:
        """Pictures (E, H, W, 3) uint8 of one person with a Look.

        Their features are normalised by the mean of the statistics of all, so that what is equal in two of them stays
        so. strength: 0 leaves the features, 1 gives them the statistics of the Look. seed: of the noise that strokes
        hang on, the same for all.
        Returns an array like ``pictures``.
        """
        values = _tensor(pictures)
        lent = []
        for features, wanted in zip(self.network.encoder(values), look.levels, strict=True):
            mean, deviation = (value.mean(0, keepdim=True) for value in statistics(features))
            steady = torch.maximum(deviation, wanted[1] / STEEPEST)
            whole = renormalised(features, (mean, steady), wanted)
            lent.append(features + strength * (whole - features))
        noise = torch.randn(1, 1, *values.shape[2:], generator=torch.Generator().manual_seed(seed))
        painted = self.network.decoder(lent, noise.expand(len(values), -1, -1, -1))
        height, width = pictures.shape[1:3]
        return (255 * painted[:, :, :height, :width].clamp(0, 1)).round().byte().permute(0, 2, 3, 1).numpy()


def style_to_checkpoint(model: StyleModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``style_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "width": model.network.width, "media": list(model.media), "recipe": model.recipe}
    return model.tensors(), about


def style_from_checkpoint(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object) -> StyleModel:
    """Rebuild a StyleModel.

    tensors, metadata: of ``style_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "style network")
        width = whole_number(metadata.get("width"), _WIDTHS, "width")
        media = metadata.get("media")
        if not isinstance(media, list) or not all(isinstance(name, str) for name in media):
            raise InputError(f"expected the names of media, found {shown(media, 60)!r}")
        count = whole_number(len(media), _MEDIA, "number of media")
        network = load_network(partial(StyleNetwork, width, count, torch.Generator()), tensors)
        return StyleModel(network, tuple(media), metadata.get("recipe"))


def _tensor(pictures: np.ndarray) -> torch.Tensor:
    """Pictures (E, H, W, 3) uint8 as (E, 3, H', W'), continued to multiples of STEP."""
    values = torch.from_numpy(pictures.astype(np.float32) / 255).permute(0, 3, 1, 2)
    height, width = values.shape[2:]
    return functional.pad(values, (0, -width % STEP, 0, -height % STEP), "replicate")
