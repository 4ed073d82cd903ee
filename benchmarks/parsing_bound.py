"""What regions a detector that knows everything would have, at the resolution at which they are read.

Usage: python benchmarks/parsing_bound.py PICTURES [COUNT]. PICTURES: a folder of `caricli dataset pictures`; its first
COUNT (default: 100) pictures of test people.

In the place of what the network sees, every window, those of the whole picture and those of the faces in their true
frames, is given the truth: its regions at every second pixel, as the network is trained ("nearest"), or the shares of
them around it ("shares"). They are put together as `caricli detect` does, and compared with the truth: intersection
over union by region.
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from caricli.data.picture_set import read_picture_set
from caricli.methods.detect.find_faces import find_faces
from caricli.methods.detect.parse_picture import WindowRegions, mean_regions, parse_picture
from caricli.methods.detect.settings import DetectSettings
from caricli.methods.evaluate.evaluate_detector import DetectorTally, JudgedPicture
from caricli.methods.train.detector.split_pictures import marked_picture
from caricli.models.detector.calibration import Calibration
from caricli.models.detector.config import HALF
from caricli.models.detector.model import Detector, FaceCells
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import Detection, FaceFrame
from caricli.structures.parsing import Region

SIZE = 128
COUNT = len(Region)


class Blind(Detector):
    """In the place of a detector: sees windows, and nothing in them."""

    def __init__(self):
        self.size = SIZE
        self.calibration = Calibration()

    def search(self, window):
        """No face, and no region."""
        nothing = FaceCells(np.zeros(1), np.zeros((1, 2)), np.ones(1), np.zeros(1), np.zeros((1, 2), int))
        return nothing, np.zeros((len(window) // HALF, window.shape[1] // HALF, COUNT))


def nearest(regions, matrix, size):
    """The region at every second pixel of a window, as probabilities."""
    moved = cv2.warpAffine(regions, matrix, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    return np.eye(COUNT)[moved[::HALF, ::HALF]]


def shares(regions, matrix, size):
    """The shares of regions around every second pixel of a window."""
    layers = 255 * (regions[..., None] == np.arange(COUNT)).astype(np.uint8)
    cut = [cut_window(np.repeat(layers[..., k : k + 1], 3, 2), matrix, size)[::HALF, ::HALF, :1] for k in range(COUNT)]
    return np.concatenate(cut, 2) / 255


def told(picture, chances, settings):
    """The regions of a MarkedPicture as they would be put together."""
    regions = np.where(picture.regions < COUNT, picture.regions, 0).astype(np.uint8)
    glances = find_faces(picture.pixels, Blind(), settings.sides, settings)[1]
    sizes = [(HALF * glance.chances.shape[1], HALF * glance.chances.shape[0]) for glance in glances]
    pairs = zip(glances, sizes, strict=True)
    whole = mean_regions([WindowRegions(chances(regions, own.matrix, size), own.matrix) for own, size in pairs])
    frames = sorted(map(FaceFrame.of, picture.landmarks), key=lambda frame: -frame.side)
    matrices = [frame.matrix(SIZE, settings.second) for frame in frames]
    faces = [WindowRegions(chances(regions, matrix, (SIZE, SIZE)), matrix) for matrix in matrices]
    return parse_picture(regions.shape, whole, [mean_regions([whole, face]) for face in faces])


def main():
    """Print the figures."""
    pictures = read_picture_set(Path(sys.argv[1]))
    numbers = pictures.pictures_of("test").tolist()[: int(sys.argv[2]) if len(sys.argv) > 2 else 100]
    for chances in (nearest, shares):
        tally = DetectorTally()
        for number in numbers:
            picture = marked_picture(pictures, number)
            judged = JudgedPicture(picture, str(number), pictures.media[number])
            tally.add(judged, Detection([], told(picture, chances, DetectSettings())))
        print(chances.__name__ + ": " + ", ".join(f"{name} {share:.2f}" for name, share in tally.intersections.items()))


if __name__ == "__main__":
    main()
