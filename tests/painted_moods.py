"""A tiny texture network that makes what moves brighter, in place of a trained one."""

import torch

from caricli.io.checkpoint import write_checkpoint
from caricli.models.texture.config import TextureSize
from caricli.models.texture.model import TextureModel, texture_to_checkpoint
from caricli.models.texture.networks import TextureNetwork


def write_brightener(path, topology_id, size=32):
    """A network file that adds a fifth of white to the whole face. Returns its path."""
    network = TextureNetwork(TextureSize(4, 4), torch.Generator().manual_seed(0))
    network.colour.last.bias.data[12:] = 0.2
    write_checkpoint(path, *texture_to_checkpoint(TextureModel(network, size, topology_id)))
    return path
