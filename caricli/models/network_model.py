"""What all networks have that have learnt."""

from typing import Any, Generic, TypeVar

import numpy as np
import torch

from caricli.models.model_id import NamedByWeights
from caricli.models.network_weights import network_weights

Network = TypeVar("Network", bound=torch.nn.Module)


class NetworkModel(NamedByWeights, Generic[Network]):
    """A network that learns no more."""

    def __init__(self, network: Network, recipe: Any = None) -> None:
        """network: weights. recipe: JSON value, how it was trained, or None."""
        self.network = network.eval().requires_grad_(False)
        self.recipe = recipe

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name, see ``network_weights``."""
        return network_weights(self.network)
