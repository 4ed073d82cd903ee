"""The style network: encoder and decoder, between them adaptive instance normalisation (Huang and Belongie 2017)."""

from collections.abc import Sequence

import torch
from torch import nn
from torch.nn import functional

from caricli.models.residual import start_convolutions, twice

Statistics = tuple[torch.Tensor, torch.Tensor]
"""Means and deviations (B, C, 1, 1) of channels."""

SMALLEST = 1e-5
"""Added to variances."""


class Encoder(nn.Module):
    """Pictures (B, 3, H, W), sRGB from 0 to 1, to features at full, half and quarter size."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.fine = _convolution(3, width)
        self.middle = _convolution(width, 2 * width, stride=2)
        self.coarse = _convolution(2 * width, 4 * width, stride=2)
        self.last = _convolution(4 * width, 4 * width)

    def forward(self, pictures: torch.Tensor) -> list[torch.Tensor]:
        """(B, C, H, W), (B, 2 C, H / 2, W / 2) and (B, 4 C, H / 4, W / 4); sides multiples of 4."""
        whole = functional.relu(self.fine(2 * pictures - 1))
        half = functional.relu(self.middle(whole))
        return [whole, half, functional.relu(self.last(functional.relu(self.coarse(half))))]


class Decoder(nn.Module):
    """Features to pictures. Noise gives strokes something to hang on where a picture is smooth."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.coarse = _convolution(4 * width, 2 * width)
        self.middle = _convolution(2 * width + 1, 2 * width)
        self.rise = _convolution(2 * width, width)
        self.fine = _convolution(width + 1, width)
        self.last = _convolution(width, 3)

    def forward(self, features: Sequence[torch.Tensor], noise: torch.Tensor) -> torch.Tensor:
        """Features of an Encoder and noise (B, 1, H, W) to (B, 3, H, W) sRGB, which may leave 0 to 1 a little."""
        fine, middle, coarse = features
        middle = middle + twice(functional.relu(self.coarse(coarse)))
        middle = functional.relu(self.middle(torch.cat([middle, 2 * functional.avg_pool2d(noise, 2)], 1)))
        fine = fine + twice(functional.relu(self.rise(middle)))
        return self.last(functional.relu(self.fine(torch.cat([fine, noise], 1)))) + 0.5


class StyleNetwork(nn.Module):
    """Encoder and decoder, and what tells media apart by statistics of features."""

    def __init__(self, width: int, media: int, generator: torch.Generator) -> None:
        """width: channels at full size. media: how many there are. generator: of the initial weights."""
        super().__init__()
        self.width = width
        self.encoder = Encoder(width)
        self.decoder = Decoder(width)
        self.media = nn.Linear(2 * 7 * width, media)
        start_convolutions(self, generator)
        nn.init.normal_(self.decoder.last.weight, std=1e-2, generator=generator)
        nn.init.normal_(self.media.weight, std=1e-2, generator=generator)
        nn.init.zeros_(self.media.bias)

    def tell(self, features: Sequence[torch.Tensor]) -> torch.Tensor:
        """Logits (B, M) of the media that pictures with such features are in."""
        return self.media(torch.cat([value.flatten(1) for level in features for value in statistics(level)], 1))


def statistics(features: torch.Tensor) -> Statistics:
    """Mean and deviation (B, C, 1, 1) of every channel of features (B, C, H, W)."""
    values = features.float()
    variance, mean = torch.var_mean(values, (2, 3), correction=0, keepdim=True)
    return mean, (variance + SMALLEST).sqrt()


def renormalised(features: torch.Tensor, own: Statistics, wanted: Statistics) -> torch.Tensor:
    """Features (B, C, H, W) with the statistics ``wanted`` in the place of their ``own`` (equation 8 of the paper)."""
    return wanted[1] * (features.float() - own[0]) / own[1] + wanted[0]


def _convolution(inputs: int, outputs: int, stride: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, stride, 1, padding_mode="replicate")
