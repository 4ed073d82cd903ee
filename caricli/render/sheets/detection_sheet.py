"""What was found in a picture, drawn over it."""

import numpy as np

from caricli.render.pixels.blend import over
from caricli.render.sheets.overlay import draw_landmarks
from caricli.structures.detection import DetectedFace, Detection
from caricli.structures.parsing import REGION_COLOURS
from caricli.structures.zoomed_pixels import zoomed_pixels

SEEN = (0, 200, 120)
HIDDEN = (255, 140, 0)
FRAME = (255, 220, 0)
DOUBT = (((60, 60, 60), 2), ((255, 255, 255), 1))
"""Colours and pixels of ellipses, the first beneath the others: on white paper as on dark skin one is seen."""

LONGEST = 2048
"""Pixels of the longer side of a picture that faces are drawn over, at most."""


def detection_sheet(picture: np.ndarray, detection: Detection, opacity: float = 0.6) -> np.ndarray:
    """Draw faces over a picture, and its regions over the same beside it.

    Frames in yellow; landmarks in green, hidden ones in orange; around each an ellipse of one standard deviation.
    picture: (H, W, 3) uint8. opacity: of the regions, 0 to 1.
    Returns (h, 2 w, 3) uint8, of the size of the picture or, where this is longer than LONGEST, smaller.
    """
    import cv2

    drawn = smaller(picture, LONGEST)
    zoom = drawn.shape[1] / picture.shape[1]
    left = drawn
    for face in detection.faces:
        left = _draw_face(left, face, zoom)
    regions = cv2.resize(detection.regions, drawn.shape[1::-1], interpolation=cv2.INTER_NEAREST_EXACT)
    colours = np.array(REGION_COLOURS, np.uint8)[regions]
    return np.concatenate([left, over(colours, drawn, opacity)], 1)


def smaller(image: np.ndarray, side: int) -> np.ndarray:
    """A picture (H, W, 3) uint8 no longer than so many pixels."""
    import cv2

    scale = min(1.0, side / max(image.shape[:2]))
    size = [max(1, round(length * scale)) for length in image.shape[1::-1]]
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def _draw_face(image: np.ndarray, face: DetectedFace, zoom: float) -> np.ndarray:
    """A face over a picture (H, W, 3) so many times as large as the one that it was found in."""
    import cv2

    picture = np.ascontiguousarray(image).copy()
    width = max(1, round(0.003 * min(image.shape[:2])))
    cv2.polylines(
        picture, [np.rint(zoomed_pixels(face.frame.corners, zoom)).astype(np.int32)], True, FRAME, width, cv2.LINE_AA
    )
    marks = face.landmarks
    assert marks.spreads is not None and marks.visibility is not None
    points = zoomed_pixels(marks.points, zoom)
    spreads = zoom**2 * marks.spreads
    ellipses = [_ellipse(*each) for each in zip(points[marks.known], spreads[marks.known], strict=True)]
    for colour, pixels in DOUBT:
        for ellipse in ellipses:
            cv2.ellipse(picture, ellipse, colour, pixels, cv2.LINE_AA)
    seen = marks.visibility >= 0.5
    hidden = np.where(seen[:, None], np.nan, points)
    picture = draw_landmarks(picture, np.where(seen[:, None], points, np.nan), SEEN)
    return draw_landmarks(picture, hidden, HIDDEN, lines=False)


def _ellipse(point: np.ndarray, spread: np.ndarray) -> tuple[list[float], list[float], float]:
    """Middle, axes and angle in degrees, as OpenCV draws them, of one standard deviation of a spread (2, 2) around a
    point (2,)."""
    values, vectors = np.linalg.eigh(spread)
    axes = 2 * np.sqrt(values[::-1])
    return point.tolist(), axes.tolist(), float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
