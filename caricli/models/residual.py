"""The units that the networks for pictures are made of."""

from collections.abc import Callable, Sequence

import torch
from torch import nn
from torch.nn import functional


class _Adding(nn.Module):
    """Convolutions that add to what goes in (He et al. 2016)."""

    def __init__(self, width: int, first: nn.Module, second: nn.Conv2d) -> None:
        super().__init__()
        self.first = first
        self.second = second
        self.norm = nn.BatchNorm2d(width)

    def forward(self, values: torch.Tensor) -> torch.Tensor:
        """(B, C, H, W) to the same."""
        return functional.relu(values + self.norm(self.second(self.first(values))))


class Residual(_Adding):
    """Two convolutions."""

    def __init__(self, width: int) -> None:
        super().__init__(width, unit(width, width), nn.Conv2d(width, width, 3, padding=1, bias=False))


class Bottleneck(_Adding):
    """Three convolutions, the middle one a quarter as wide, as of a ResNet-50."""

    def __init__(self, width: int) -> None:
        narrow = nn.Sequential(unit(width, width // 4, kernel=1), unit(width // 4, width // 4))
        super().__init__(width, narrow, nn.Conv2d(width // 4, width, 1, bias=False))


def unit(inputs: int, outputs: int, kernel: int = 3, stride: int = 1) -> nn.Sequential:
    """A convolution, normalised and rectified."""
    convolution = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


def encoder_levels(
    stem: int, widths: Sequence[int], blocks: Sequence[int], block: Callable[[int], nn.Module]
) -> nn.ModuleList:
    """Levels of a network, each of half the size of that before it.

    stem: channels that go into the first. widths, blocks: channels, and how many blocks, of each. block: made by width.
    """
    levels = zip((stem, *widths), widths, blocks, strict=False)
    return nn.ModuleList(
        nn.Sequential(unit(before, width, stride=2), *(block(width) for _ in range(count)))
        for before, width, count in levels
    )


def twice(values: torch.Tensor) -> torch.Tensor:
    """Values (B, C, H, W) of twice the height and width, each four times."""
    return functional.interpolate(values, scale_factor=2, mode="nearest")


def start_linear(layer: nn.Linear, generator: torch.Generator) -> None:
    """Draw the initial weights of a layer that is rectified."""
    nn.init.kaiming_normal_(layer.weight, nonlinearity="relu", generator=generator)
    nn.init.zeros_(layer.bias)


def start_plainly(layer: nn.Linear) -> None:
    """Let a layer give zeros at first."""
    nn.init.zeros_(layer.weight)
    nn.init.zeros_(layer.bias)


def start_convolutions(network: nn.Module, generator: torch.Generator | None) -> None:
    """Draw the initial weights of all convolutions; what adds to something adds nothing at first.

    generator: None where weights are to be loaded, for which they are only laid out.
    """
    for module in network.modules():
        if isinstance(module, nn.Conv2d):
            # As processors like it best.
            module.weight.data = module.weight.data.contiguous(memory_format=torch.channels_last)
        if generator is None:
            continue
        if isinstance(module, nn.Conv2d):
            nn.init.kaiming_normal_(module.weight, nonlinearity="relu", generator=generator)
            if module.bias is not None:
                nn.init.zeros_(module.bias)
        if isinstance(module, _Adding):
            nn.init.zeros_(module.norm.weight)
