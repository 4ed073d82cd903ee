"""Colours of pictures at places of them."""

import cv2
import numpy as np
import scipy.sparse as sp

_WIDTH = 4096


def sample_pixels(image, x, y, interpolation=cv2.INTER_LINEAR, border=None):
    """Sample a picture at pixels; the centre of the top-left one is (0, 0).

    image: (H, W) or (H, W, C). x, y: (N,). interpolation: of OpenCV. border: value outside the picture; where there is
    none, its outermost pixels go on.
    Returns (N,) or (N, C).
    """
    # OpenCV takes no more than 32,767 rows or columns.
    rows = max(-(-len(x) // _WIDTH), 1)
    places = [np.resize(np.asarray(a, np.float32), (rows, _WIDTH)) for a in (x, y)]
    mode = {"borderMode": cv2.BORDER_REPLICATE} if border is None else {"borderMode": cv2.BORDER_CONSTANT,
                                                                        "borderValue": border}  # fmt: skip
    samples = cv2.remap(image, *places, interpolation, **mode)
    return samples.reshape(-1, *image.shape[2:])[: len(x)]


def sample_texture(texture, uvs):
    """Bilinear samples (N, C). texture: (H, W, C) uint8, the top row first. uvs: (N, 2), origin bottom left."""
    height, width = texture.shape[:2]
    return sample_pixels(texture, uvs[:, 0] * width - 0.5, (1 - uvs[:, 1]) * height - 0.5).astype(np.float64)


def texture_matrix(owner, count, uvs):
    """What `sample_texture` takes of every colour, where texels share colours.

    owner: (H, W) int, the colour that a texel has, of ``count``. uvs: (N, 2). Returns (N, count), sparse.
    """
    height, width = owner.shape
    places = np.stack([uvs[:, 0] * width - 0.5, (1 - uvs[:, 1]) * height - 0.5], axis=1)
    first, points = np.floor(places).astype(int), np.arange(len(uvs))
    rest, matrix = places - first, 0
    for right, down in np.ndindex(2, 2):
        column, row = np.clip(first[:, 0] + right, 0, width - 1), np.clip(first[:, 1] + down, 0, height - 1)
        part = np.abs(1 - right - rest[:, 0]) * np.abs(1 - down - rest[:, 1])
        matrix = matrix + sp.csr_matrix((part, (points, owner[row, column])), (len(uvs), count))
    return matrix
