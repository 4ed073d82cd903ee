"""The way that strokes go: along what a picture shows, not across it."""

import numpy as np

from caricli.methods.stylise.canvas import Canvas

_FAR = 4.0
_FAINT = 0.03
"""Where nothing is near, strokes go as far away, faintly."""


def flow(canvas: Canvas, units: float) -> np.ndarray:
    """(H, W, 2) float32 unit vectors x, y along edges, smoothed over so many units; their sign means nothing.

    The smaller eigenvector of the smoothed structure tensor (Kang, Lee and Chui 2007; Kyprianidis and Doellner 2008).
    """
    import cv2

    light = canvas.blurred(canvas.guiding_light, 0.5)
    across, down = cv2.Scharr(light, cv2.CV_32F, 1, 0), cv2.Scharr(light, cv2.CV_32F, 0, 1)
    tensor = np.dstack([across * across, across * down, down * down])
    tensor = canvas.blurred(tensor, units) + _FAINT * canvas.blurred(tensor, _FAR * units)
    angle = 0.5 * np.arctan2(2 * tensor[..., 1], tensor[..., 0] - tensor[..., 2]) + np.pi / 2
    return np.dstack([np.cos(angle), np.sin(angle)]).astype(np.float32)


def smeared(values: np.ndarray, ways: np.ndarray, length: float) -> np.ndarray:
    """Values (H, W) float32 smeared both ways along ``ways`` (H, W, 2), over about so many pixels."""
    import cv2

    height, width = values.shape
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    reach = 1.0
    while reach <= max(length / 2, 1.0):
        for _ in range(2):
            sides = [
                cv2.remap(
                    values,
                    columns + sign * reach * ways[..., 0],
                    rows + sign * reach * ways[..., 1],
                    cv2.INTER_LINEAR,
                    borderMode=cv2.BORDER_REFLECT,
                )
                for sign in (-1, 1)
            ]
            values = (values + sides[0] + sides[1]) / 3
        reach *= 2
    return values


def lines(canvas: Canvas, ways: np.ndarray, units: float, depth: float) -> np.ndarray:
    """(H, W) float32, how dark a pen would draw here, 0 to 1: lines where light falls off.

    Differences of Gaussians, sharpened and smeared along the flow (Winnemoeller, Kyprianidis and Olsen 2012).
    canvas: Canvas. ways: of ``flow``. units: width of a line. depth: contrast, 0 to 1, from which on lines are black.
    """
    inner = canvas.blurred(canvas.light, 0.5 * units)
    outer = canvas.blurred(canvas.light, 0.8 * units)
    # Relative to the light, so that the dark half of a face has lines, too.
    falls = smeared((outer - inner) / (outer + 0.15), ways, 4 * units * canvas.unit)
    return np.clip(falls / depth, 0, 1)
