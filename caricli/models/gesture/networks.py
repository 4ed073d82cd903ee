"""The gesture network (sketch paper, section 5.2)."""

import torch
from torch import nn
from torch.nn import functional

from caricli.models.gesture.config import POOLED
from caricli.models.residual import start_convolutions, start_linear

_HIDDEN = 256


class GestureNetwork(nn.Module):
    """Pictures of strokes to logits: the layers of the paper, whose strides are not told.

    11x11x32, 5x5x64 and 3x3x16 convolutions, each with a ReLU and 3x3 max pooling at every second place, then 256 and
    as many values as there are gestures, fully connected. The paper says nine for ten gestures.
    """

    def __init__(self, size: int, stride: int, outputs: int, generator: torch.Generator) -> None:
        """size: pixels, a multiple of 8 strides. stride: of the first layer. generator: of the initial weights."""
        super().__init__()
        self.size = size
        self.stride = stride
        self.first = nn.Conv2d(1, 32, 11, stride, 5)
        self.second = nn.Conv2d(32, 64, 5, 1, 2)
        self.third = nn.Conv2d(64, 16, 3, 1, 1)
        self.hidden = nn.Linear(16 * (size // (POOLED * stride)) ** 2, _HIDDEN)
        self.last = nn.Linear(_HIDDEN, outputs)
        start_convolutions(self, generator)
        for layer in (self.hidden, self.last):
            start_linear(layer, generator)

    def forward(self, pictures: torch.Tensor) -> torch.Tensor:
        """Ink (B, 1, S, S) from 0 to 1 to logits (B, G)."""
        values = pictures
        for layer in (self.first, self.second, self.third):
            values = functional.max_pool2d(functional.relu(layer(values)), 3, 2, 1)
        return self.last(functional.relu(self.hidden(values.flatten(1))))
