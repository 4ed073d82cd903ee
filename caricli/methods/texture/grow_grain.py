"""The grain of what is seen of a skin, on what is not."""

from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from caricli.render.pixels.distance_to import exact_distance_to

_COMPARED = 12  # texels along a patch by which it is compared
_SHRINK = 4  # times that a texture is smaller where its colours are taken
_SMALL = 1e-6


@dataclass(frozen=True)
class GrainSettings:
    """How grain is told from colour, and grown.

    coarse: share of the texture's side, radius of what counts as colour: grain is finer. patch: share of the side,
    width of the squares that are taken. overlap: share of a patch that is laid over the one before. candidates: places
    that they are taken from. whole: share of a patch that has to be seen. quiet: quantile of the strength of patches
    up to which they are taken: moles and wrinkles are no grain. likely: those are drawn from, so that nothing repeats,
    that fit worse than the best one by no more than this share of how well it does. most: largest grain, of the colour.
    """

    coarse: float = 0.008
    patch: float = 0.0625
    overlap: float = 0.375
    candidates: int = 32
    whole: float = 0.97
    quiet: float = 0.25
    likely: float = 0.2
    most: float = 0.25


def grow_grain(image: np.ndarray, seen: np.ndarray, regions: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Lay the grain of what is seen, as of paper, brush or pores, over what is filled smoothly.

    Image quilting (Efros and Freeman 2001) of what is finer than the colours, relative to these: squares, row by row,
    each the one that differs least from what it overlaps. Overlaps are mixed so that grain stays as strong as it is.

    image: (S, S, 3) from 0 to 255. seen: (S, S) from 0 to 1. regions: (S, S) int, 0 for what neither gives nor takes
    grain; any other region takes its own, or that of region 1 where too little of it is seen. generator: of the
    patches that are compared.
    Returns (S, S, 3), what is seen unchanged. All is unchanged where too little is seen.
    """
    settings = GrainSettings()
    image = image.astype(np.float32)
    grain = _grain(image, (seen == 1) & (regions > 0), settings)
    grown = np.zeros_like(grain)
    usual = None
    for region in range(1, int(regions.max(initial=0)) + 1):
        here = regions == region
        patches = _patches(grain, here & (seen == 1), generator, settings)
        if patches is None:
            patches = usual
        if region == 1:
            usual = patches
        if patches is not None:
            wanted = here & (seen < 1)
            grown[wanted] = _quilt(grain, here & (seen == 1), wanted, patches, generator, settings)
    # A texture goes on elsewhere beyond the border of its islands: there is no grain to be joined.
    border = exact_distance_to(regions <= 0)
    share = (1 - seen) * np.clip(border / (2 * settings.coarse * len(image)), 0, 1)
    return image * (1 + share.astype(np.float32)[..., None] * grown)


def _grain(image: np.ndarray, source: np.ndarray, settings: GrainSettings) -> np.ndarray:
    """(S, S, 3) float32 what of the image is finer than its colours, relative to these, 0 beside the source."""
    size = max(len(image) // _SHRINK, 1)
    colours, share = (
        cv2.GaussianBlur(cv2.resize(each, (size, size), interpolation=cv2.INTER_AREA), (0, 0), settings.coarse * size)
        for each in (_within(image, source), source.astype(np.float32))
    )
    smooth = np.maximum(cv2.resize(colours / np.maximum(share, 1e-3)[..., None], image.shape[1::-1]), 1)
    grain = image / smooth
    grain -= 1
    return _within(np.clip(grain, -settings.most, settings.most, out=grain), source)


def _within(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """An image (S, S, C) in a mask (S, S) bool, and zero elsewhere."""
    return cv2.copyTo(image, mask.view(np.uint8))


def _patches(
    grain: np.ndarray, source: np.ndarray, generator: np.random.Generator, settings: GrainSettings
) -> np.ndarray | None:
    """(K, P, P, 3) quiet squares of the source (S, S) bool, or None."""
    side = max(int(settings.patch * len(grain)), 4)
    in_square = partial(cv2.boxFilter, ddepth=-1, ksize=(side, side), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
    share = in_square(source.astype(np.float32))
    row, column = np.nonzero(share[: len(share) - side + 1, : len(share) - side + 1] >= settings.whole)
    if len(row) == 0:
        return None
    strength = in_square(np.einsum("ijk,ijk->ij", grain, grain))
    quiet = strength[row, column] <= np.quantile(strength[row, column], settings.quiet)
    chosen = generator.choice(np.flatnonzero(quiet), min(settings.candidates, int(quiet.sum())), replace=False)
    patches = np.stack([grain[r : r + side, c : c + side] for r, c in zip(row[chosen], column[chosen], strict=True)])
    turned = np.concatenate([patches, patches.transpose(0, 2, 1, 3)])
    return np.concatenate([turned, turned[:, ::-1], turned[:, :, ::-1], turned[:, ::-1, ::-1]])


def _quilt(
    grain: np.ndarray,
    given: np.ndarray,
    wanted: np.ndarray,
    patches: np.ndarray,
    generator: np.random.Generator,
    settings: GrainSettings,
) -> np.ndarray:
    """(N, 3) grain of the N places where it is wanted (S, S) bool, joined to what is given (S, S) bool."""
    side = patches.shape[1]
    step = side - int(settings.overlap * side)
    ramp = np.minimum(1, (np.arange(side) + 0.5) / (side - step))
    window = np.minimum(ramp, ramp[::-1])
    weight = (window[:, None] * window).astype(np.float32)[..., None]
    rough = np.s_[:: max(side // _COMPARED, 1)]
    compared = patches[:, rough, rough].reshape(len(patches), -1)
    size = compared**2
    border = ((0, side), (0, side))
    # Of every texel the weighted sum of what was laid there, and the sum of the squares of weights: so mixed, grain
    # that has nothing to do with each other stays as strong as it was.
    squares = np.pad(given.astype(np.float32), border)[..., None]
    total = cv2.copyMakeBorder(_within(grain, given), 0, side, 0, side, cv2.BORDER_CONSTANT)
    free = squares == 0
    wanted = np.pad(wanted, border)
    for row in range(0, len(grain), step):
        for column in range(0, len(grain), step):
            at = np.s_[row : row + side, column : column + side]
            if not wanted[at].any():
                continue
            laid = squares[at][rough, rough]
            joined = np.minimum(laid, 1)
            before = joined * total[at][rough, rough] / np.sqrt(np.maximum(laid, _SMALL))
            difference = size @ np.repeat(joined, 3, axis=2).ravel() - 2 * compared @ before.ravel()
            likely = difference - difference.min() <= settings.likely * np.abs(difference.min())
            share = weight * free[at]
            total[at] += share * patches[generator.choice(np.flatnonzero(likely))]
            squares[at] += share**2
    return total[wanted] / np.sqrt(np.maximum(squares[wanted], _SMALL))
