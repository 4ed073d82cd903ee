"""What all networks have that have learnt."""

from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
import torch

from caricli.models.checkpoint import model_id
from caricli.models.network_weights import network_weights

Network = TypeVar("Network", bound=torch.nn.Module)


class NetworkModel(Generic[Network]):
    """A network that learns no more. kind: what its files call it."""

    kind: ClassVar[str]

    def __init__(self, network: Network, recipe: Any = None) -> None:
        """network: weights. recipe: JSON value, how it was trained, or None."""
        self.network = network.eval().requires_grad_(False)
        self.recipe = recipe

    @property
    def model_id(self) -> str:
        """SHA-256 of its weights."""
        return model_id(self.kind, self.tensors())

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name, see ``network_weights``."""
        return network_weights(self.network)
