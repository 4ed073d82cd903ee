"""Faces of real photographs that are found at 25 pixels, and what is no face and is taken for one.

The 200 windows of 25 pixels of scikit-image's part of Labeled Faces in the Wild, grey, the first half of them faces,
the rest what lies around such faces; as they are, enlarged fourfold, and with their borders drawn out by half and
enlarged. Beside the detector stands what scikit-image brings, OpenCV's cascade of local binary patterns.

Usage: python -m benchmarks.small_photographs [DETECTOR.safetensors]. The last line is JSON.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np
from skimage.data import lbp_frontal_face_cascade_filename, lfw_subset
from skimage.feature import Cascade

from caricli.methods.detect.detect_faces import detect_faces
from caricli.store.detector import load_detector

FACES = 100
ENLARGED = 4
BORDER = 12
WINDOWS = {"as they are": (1, 0), "enlarged fourfold": (ENLARGED, 0), "with a border, enlarged": (ENLARGED, BORDER)}
LEAST, MOST = 0.3, 1.0
"""Sides of what the cascade looks for, of a picture's."""


def shown(window, scale, border):
    """A window (H, W) of 0 to 1 as a picture (h, w, 3) uint8."""
    grey = cv2.copyMakeBorder((255 * window).astype(np.uint8), *[border] * 4, cv2.BORDER_REPLICATE)
    grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    return np.repeat(grey[..., None], 3, 2)


def by_cascade(cascade, picture):
    """Whether the cascade finds a face in a picture."""
    least, most = (int(share * len(picture)) for share in (LEAST, MOST))
    return bool(cascade.detect_multi_scale(picture, 1.1, 1, (least, least), (most, most)))


def main():
    """Print the table."""
    detector = load_detector(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    cascade = Cascade(lbp_frontal_face_cascade_filename())
    finders = {
        "detector": lambda picture: bool(detect_faces(picture, detector).faces),
        "cascade": lambda picture: by_cascade(cascade, picture),
    }
    rows = []
    for windows, look in WINDOWS.items():
        for finder, finds in finders.items():
            is_face = [finds(shown(window, *look)) for window in lfw_subset()]
            row = {"windows": windows, "finder": finder, "faces": sum(is_face[:FACES]), "others": sum(is_face[FACES:])}
            rows.append(row)
            print("{finder:8} {windows:24} {faces:3} of 100 faces, {others:3} of 100 others".format(**row))
    print(json.dumps({"windows": rows}))


if __name__ == "__main__":
    main()
