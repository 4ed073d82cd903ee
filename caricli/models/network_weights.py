"""The weights of a network for pictures as a file holds them."""

from collections.abc import Mapping

import numpy as np
import torch

from caricli.models.checks import fitting_weights, foreign_weights
from caricli.models.half_precision import in_half_precision


def network_weights(network: torch.nn.Module) -> dict[str, np.ndarray]:
    """Arrays by name: weights in half precision, statistics of normalisation and other columns in single."""
    return in_half_precision({name: value.cpu().numpy() for name, value in _weights(network).items()})


def load_weights(network: torch.nn.Module, tensors: Mapping[str, np.ndarray]) -> None:
    """Put arrays into a network that they fit. Raises InputError when they are those of another one."""
    own = _weights(network)
    if sorted(own) != sorted(tensors):
        odd = sorted(set(own) ^ set(tensors))[0]
        raise foreign_weights(odd)
    for name, value in own.items():
        value.copy_(torch.from_numpy(fitting_weights(name, tensors[name], tuple(value.shape))))


def _weights(network: torch.nn.Module) -> dict[str, torch.Tensor]:
    """Its tensors by name, without counters."""
    return {name: value.detach() for name, value in network.state_dict().items() if value.is_floating_point()}
