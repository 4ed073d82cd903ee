"""The texture network as it is used: weights, the size of its chart, and the topology whose chart it is."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming, shown
from caricli.models.checks import check_schema, network_size, window_side
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.models.texture.config import STEP, TextureSize
from caricli.models.texture.networks import Change, TextureNetwork
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.texture_change import Manner, TextureChange

SCHEMA = "caricli.texture_network/1"

_SIDES = (32, 512)
_TOPOLOGY = 64
"""Characters of a topology's id."""


class TextureModel(NetworkModel[TextureNetwork]):
    """Tells what an expression does to a texture in the chart of a topology."""

    kind = "texture"

    def __init__(self, network: TextureNetwork, size: int, topology_id: str, recipe: Any = None) -> None:
        """network: weights. size: of the chart, texels. topology_id: of the mesh whose chart it knows.

        recipe: JSON value, how it was trained, or None.
        """
        super().__init__(network, recipe)
        self.size = size
        self.topology_id = topology_id

    @torch.inference_mode()
    def change(
        self, picture: np.ndarray, maps: np.ndarray, source: np.ndarray, target: np.ndarray, manner: Manner
    ) -> TextureChange:
        """What the step from one expression to another does to a texture.

        picture: (S, S, 3) uint8 sRGB, in the chart. maps: (S, S, 23) of ``pair_maps``. source, target: (52,) ARKit
        weights of what the texture shows, and of what it is to show. manner: Manner of the picture.
        """
        codes = torch.from_numpy(np.concatenate([source, target]).astype(np.float32))[None]
        colours = _tensor(picture / 255.0)
        change = self.network(colours, _tensor(maps), codes)
        shades = torch.from_numpy(np.asarray(manner.shades, np.float32))[None]
        share, skin = (torch.from_numpy(np.asarray(part, np.float32)) for part in (manner.share, manner.skin))
        shaded = change.in_own_shades(colours, shades, share)
        folded = shaded.with_folds_up_to(colours, torch.tensor([manner.deepest]), shades, skin)
        return _numpy(folded.toned(torch.tensor([manner.coloured])))


def texture_to_checkpoint(model: TextureModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``texture_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(model.network.size), "size": model.size}
    about |= {"topology_id": model.topology_id, "expressions": list(ARKIT_NAMES), "recipe": model.recipe}
    return model.tensors(), about


def texture_from_checkpoint(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object
) -> TextureModel:
    """Rebuild a TextureModel.

    tensors, metadata: of ``texture_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "texture network")
        if metadata.get("expressions") != list(ARKIT_NAMES):
            raise InputError("expected a texture network of ARKit's 52 expressions, found one of others")
        topology_id = metadata.get("topology_id")
        if not isinstance(topology_id, str) or len(topology_id) != _TOPOLOGY:
            raise InputError(f"expected the id of a topology, found {shown(topology_id, 60)!r}")
        size = window_side(metadata.get("size"), _SIDES, STEP)
        own = network_size(metadata.get("network"), TextureSize)
        network = load_network(partial(TextureNetwork, own, torch.Generator()), tensors)
        return TextureModel(network, size, topology_id, metadata.get("recipe"))


def _tensor(picture: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(picture, np.float32)).permute(2, 0, 1)[None]


def _numpy(change: Change) -> TextureChange:
    gain, offset = ((change.attention * part)[0].permute(1, 2, 0).numpy() for part in (change.gain, change.offset))
    return TextureChange(gain, offset)
