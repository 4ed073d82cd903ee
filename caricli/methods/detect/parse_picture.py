"""What every pixel of a picture shows."""

from dataclasses import dataclass

import numpy as np

from caricli.models.detector.config import HALF
from caricli.models.detector.model import Detector

_EDGE = 4
"""Pixels of a window's map at its edge, where the network has seen little around them."""


@dataclass(frozen=True, eq=False)
class WindowRegions:
    """What a window shows.

    chances: (h, w, R) probabilities of regions. matrix: (2, 3) map from the picture's pixels to those of a window, of
    which the pixel j of the chances is at HALF j.
    """

    chances: np.ndarray
    matrix: np.ndarray

    @classmethod
    def of(cls, chances: np.ndarray, matrix: np.ndarray, detector: Detector) -> "WindowRegions":
        """What a detector sees in a window. matrix: (2, 3) map from the picture's pixels to the window's."""
        return cls(chances, matrix - np.column_stack([np.zeros((2, 2)), detector.calibration.shift]))


def parse_picture(shape: tuple[int, int], whole: WindowRegions, faces: list[WindowRegions]) -> np.ndarray:
    """Put the regions of a whole picture and of the windows of its faces together.

    shape: (height, width). faces: the first over the others.
    Returns (height, width) uint8 values of Region.
    """
    regions = np.zeros(shape, np.uint8)
    _lay(regions, whole, edge=0)
    for face in reversed(faces):
        _lay(regions, face, _EDGE)
    return regions


def mean_regions(windows: list[WindowRegions]) -> WindowRegions:
    """What windows show in the mean, in the pixels of the last."""
    return WindowRegions(np.mean([_seen_in(window, windows[-1]) for window in windows], axis=0), windows[-1].matrix)


def _seen_in(window: WindowRegions, other: WindowRegions) -> np.ndarray:
    """Probabilities of a window at the pixels of the map of another; beyond its edges it goes on as it ends."""
    import cv2

    if window is other:
        return window.chances
    back = np.linalg.inv(np.vstack([other.matrix / HALF, [0, 0, 1]]))
    height, width = other.chances.shape[:2]
    layers = [
        cv2.warpAffine(
            np.ascontiguousarray(layer, np.float32),
            window.matrix / HALF @ back,
            (width, height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        for layer in np.moveaxis(window.chances, 2, 0)
    ]
    return np.stack(layers, -1)


def _lay(regions: np.ndarray, window: WindowRegions, edge: int) -> None:
    """Write the likeliest regions of a window over regions (H, W).

    edge: pixels of its map that are left out around it, or 0 where it is of the whole picture.
    """
    import cv2

    chances = window.chances
    to_chances = window.matrix / HALF
    height, width = chances.shape[:2]
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - to_chances[:, 2]
    there = np.linalg.solve(to_chances[:, :2], corners.T).T
    limits = np.array(regions.shape[::-1])
    low = np.clip(np.floor(there.min(0)), 0, limits).astype(int)
    high = np.clip(np.ceil(there.max(0)) + 1, low, limits).astype(int)
    size = (high - low).tolist()
    if min(size) == 0:
        return
    moved = to_chances.copy()
    moved[:, 2] += to_chances[:, :2] @ low
    best = np.zeros((size[1], size[0]), np.uint8)
    label = np.zeros((size[1], size[0]), np.uint8)
    smooth = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    for region in np.flatnonzero(chances.max((0, 1)) > 1 / chances.shape[2]):
        layer = np.rint(255 * chances[..., region]).astype(np.uint8)
        moved_layer = cv2.warpAffine(layer, moved, size, flags=smooth, borderMode=cv2.BORDER_REPLICATE)
        label[moved_layer > best] = region
        np.maximum(best, moved_layer, out=best)
    inner = np.zeros((height, width), np.uint8)
    inner[edge : height - edge, edge : width - edge] = 1
    inside = cv2.warpAffine(inner, moved, size, flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP) > 0
    part = regions[low[1] : high[1], low[0] : high[0]]
    part[inside] = label[inside]
