"""Muon for the kernels of convolutions and of fully connected layers."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import nn


class KernelMuon(torch.optim.Muon):
    """Muon (Jordan et al. 2024), for which each kernel is a matrix: a row for every channel or number that comes out.

    Every direction of a kernel's momentum goes a step of the same length. Rates are as those of AdamW, whose steps have
    about the same mean square.
    """

    def __init__(self, kernels: Sequence[torch.Tensor], lr: float, weight_decay: float) -> None:
        """kernels: (O, I), or (O, I, h, w) in channels_last, which stay where they are in memory."""
        self.kernels = kernels
        matrices = [nn.Parameter(_rows(kernel.detach()).view(len(kernel), -1)) for kernel in kernels]
        super().__init__(matrices, lr=lr, weight_decay=weight_decay, adjust_lr_fn="match_rms_adamw")

    def step(self, closure: Any = None) -> Any:
        """Go one step, by the gradients of the kernels."""
        for matrix, kernel in zip(self.param_groups[0]["params"], self.kernels, strict=True):
            matrix.grad = None if kernel.grad is None else _rows(kernel.grad).flatten(1)
        return super().step(closure)


def normalised_kernels(network: nn.Module) -> list[torch.Tensor]:
    """The kernels of all convolutions without a bias, whose length does not count, because they are normalised."""
    layers = [layer for layer in network.modules() if isinstance(layer, nn.Conv2d) and layer.bias is None]
    return [layer.weight for layer in layers]


def _rows(kernel: torch.Tensor) -> torch.Tensor:
    """(O, I, h, w) as (O, h, w, I), the order of channels_last; (O, I) as it is."""
    return kernel.permute(0, 2, 3, 1) if kernel.ndim > 2 else kernel
