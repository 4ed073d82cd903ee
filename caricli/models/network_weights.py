"""The weights of a network for pictures as a file holds them."""

from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np
import torch

from caricli.models.checks import fitting_weights, foreign_weights
from caricli.models.half_precision import in_half_precision

Network = TypeVar("Network", bound=torch.nn.Module)


def network_weights(network: torch.nn.Module) -> dict[str, np.ndarray]:
    """Arrays by name: weights in half precision, statistics of normalisation and other columns in single."""
    return in_half_precision({name: value.cpu().numpy() for name, value in _weights(network).items()})


def load_network(build: Callable[[], Network], tensors: Mapping[str, np.ndarray]) -> Network:
    """A network with the weights of a file, which it must fit; it is built only once these are known to.

    build: gives the network, whose size a file may claim to be anything. Raises InputError when the arrays are those
    of another one.
    """
    with torch.device("meta"):
        shapes = {name: tuple(value.shape) for name, value in _weights(build()).items()}
    if sorted(shapes) != sorted(tensors):
        odd = sorted(set(shapes) ^ set(tensors))[0]
        raise foreign_weights(odd)
    weights = {name: fitting_weights(name, tensors[name], shape) for name, shape in shapes.items()}
    network = build()
    for name, value in _weights(network).items():
        value.copy_(torch.from_numpy(weights[name]))
    return network


def _weights(network: torch.nn.Module) -> dict[str, torch.Tensor]:
    """Its tensors by name, without counters."""
    return {name: value.detach() for name, value in network.state_dict().items() if value.is_floating_point()}
