"""What every pixel of a picture shows."""

import numpy as np

from caricli.methods.detect.find_faces import Glance
from caricli.methods.detect.read_faces import ReadFace
from caricli.models.detector.networks import HALF

_EDGE = 4
"""Pixels of a window's map at its edge, where the network has seen little around them."""


def parse_picture(shape: tuple[int, int], glance: Glance, faces: list[ReadFace]) -> np.ndarray:
    """Put the regions of a whole picture and of the windows of its faces together.

    shape: (height, width). glance: the picture as a whole. faces: the first over the others.
    Returns (height, width) uint8 values of Region.
    """
    regions = np.zeros(shape, np.uint8)
    _lay(regions, glance.regions, glance.matrix, edge=0)
    for face in reversed(faces):
        _lay(regions, face.regions, face.matrix, _EDGE)
    return regions


def _lay(regions: np.ndarray, chances: np.ndarray, matrix: np.ndarray, edge: int) -> None:
    """Write the likeliest of chances (h, w, R) over regions (H, W).

    matrix: (2, 3) from the pixels of the regions to those of the window, HALF of which are one of the chances. edge:
    pixels of the chances that are left out around them, or 0 where they are of the whole picture.
    """
    import cv2

    to_chances = matrix / HALF
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
