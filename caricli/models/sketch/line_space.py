"""Points along curves in a few numbers, those of curves that are not drawn as the others make them likely."""

import numpy as np
import torch
from torch import nn

_LEAST = 1e-12
"""Variance of what is left of points: lines without any noise leave nothing."""

_DOT = 1e-6
"""Of half of the window's side: the least reach of lines."""

_STEADY = 1e-2
"""Added to squares of what is left of a line, in variances of it, before their logarithm."""


class LineSpace(nn.Module):
    """Probabilistic principal components of points (Tipping and Bishop 1999).

    Points are first moved and scaled so that those of the curves that are drawn have the middle and the reach of their
    usual places: windows are around what is drawn, whatever that is. Then a point is ``usual`` (K, P, 2) + what M
    independent numbers of variance 1 make of it + noise, whose standard deviation ``spread`` is the same for all.
    ``rows`` (2 K P, M) are orthonormal but for factors below 1; ``floor`` (M,) are the noise's variance over those
    along the rows.
    """

    usual: torch.Tensor
    spread: torch.Tensor
    rows: torch.Tensor
    floor: torch.Tensor

    def __init__(self, curves: int, points: int, components: int) -> None:
        """curves, points, components: K, P and M."""
        super().__init__()
        self.register_buffer("usual", torch.zeros(curves, points, 2))
        self.register_buffer("spread", torch.ones(()))
        self.register_buffer("rows", torch.zeros(2 * curves * points, components))
        self.register_buffer("floor", torch.ones(components))

    def learn(self, points: np.ndarray, there: np.ndarray) -> None:
        """Take mean, components and noise of points (N, K, P, 2), N at least M, moved as if only the curves ``there``
        (N, K) were drawn; of few curves so few components that noise is left, and the other numbers are always 0.
        """
        lines = torch.from_numpy(points).float()
        self.usual.copy_(lines.mean(0))
        flat = self.placed(lines, torch.from_numpy(there))[0].flatten(1).double().numpy()
        variances, directions = np.linalg.eigh(np.cov(flat.T))
        count = min(len(self.floor), len(variances) * 3 // 4)
        noise = max(variances[:-count].mean(), _LEAST)
        floor = noise / np.maximum(variances[: -count - 1 : -1], noise)
        rows = directions[:, : -count - 1 : -1] * np.sqrt(1 - floor)
        values = (flat.mean(0).reshape(self.usual.shape), np.asarray(np.sqrt(noise)), rows, floor)
        buffers = (self.usual, self.spread, self.rows[:, :count], self.floor[:count])
        for buffer, value in zip(buffers, values, strict=True):
            buffer.copy_(torch.from_numpy(value))

    @torch.no_grad()
    def placed(self, points: torch.Tensor, there: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Points (B, K, P, 2) where they usually are, and the scale (B,) and shift (B, 2) that brought them there.

        there: (B, K) bool, which curves are drawn; points of others may be NaN.
        """
        shares = there.to(self.usual.dtype)[..., None, None] / (there.sum(1)[:, None, None, None] * points.shape[2])
        middles = []
        reaches = []
        for lines in (torch.where(there[..., None, None], points, 0), self.usual.expand(points.shape)):
            middle = (shares * lines).sum((1, 2), keepdim=True)
            middles.append(middle)
            reaches.append((shares * (lines - middle).square()).sum((1, 2, 3)).sqrt())
        scale = reaches[1] / reaches[0].clamp_min(_DOT)
        shift = (middles[1] - scale[:, None, None, None] * middles[0])[:, 0, 0]
        return scale[:, None, None, None] * points + shift[:, None, None], scale, shift

    @torch.no_grad()
    def forward(self, points: torch.Tensor, there: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Expected numbers (B, M) of ``placed`` points (B, K, P, 2), and what they leave of every curve (B, K), as a
        logarithm.

        there: (B, K) bool, which curves are drawn; what is left of others is 0.
        """
        gaps = torch.where(there[..., None, None], (points - self.usual) / self.spread, 0)
        numbers = gaps.flatten(1) @ self.rows
        lacking = ~there.all(1)
        if lacking.any():
            of_curves = self.rows.unflatten(0, (len(self.usual), -1))
            products = (of_curves.mT @ of_curves).flatten(1)
            systems = (there[lacking].to(products.dtype) @ products).unflatten(1, 2 * (len(self.floor),))
            factors = torch.linalg.cholesky(systems + torch.diag(self.floor))
            numbers[lacking] = torch.cholesky_solve(numbers[lacking, :, None], factors)[..., 0]
        left = (gaps.flatten(2) - (numbers @ self.rows.T).view_as(gaps).flatten(2)).square().mean(2)
        return numbers * self.floor.sqrt(), torch.where(there, torch.log(left + _STEADY), 0)
