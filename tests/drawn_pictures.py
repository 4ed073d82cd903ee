"""Pictures of simple drawn faces whose landmarks and regions are known."""

import cv2
import numpy as np

from caricli.data.picture_set import PictureWriter, encode_labels, encode_picture
from caricli.structures.detection import MarkedPicture
from caricli.structures.landmarks import BROW_LEFT, BROW_RIGHT, EYE_LEFT, EYE_RIGHT, LIPS, LIPS_INSIDE
from caricli.structures.parsing import Region

SIZE = 160


def mean_shape(template):
    """(81, 2) landmarks of a head from the front, y down, the face one unit wide."""
    points = template.vertices[list(template.annotation.landmarks)][:, :2] * [1, -1]
    return (points - points[:68].mean(0)) / np.ptp(points[:17, 0])


def drawn_picture(shape, generator, faces=1):
    """A MarkedPicture of (160, 160) pixels with so many faces in it, side by side."""
    pixels = np.full((SIZE, SIZE, 3), generator.integers(0, 256, 3), np.uint8)
    regions = np.zeros((SIZE, SIZE), np.uint8)
    marks = []
    for k in range(faces):
        angle = generator.normal(0, 0.2)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        scale = generator.uniform(0.35, 0.6) * SIZE / faces
        centre = np.array([(k + 0.5) / faces, 0.5]) * SIZE + generator.normal(0, 4, 2)
        points = (shape + generator.normal(0, 0.01, shape.shape)) @ turn.T * scale + centre
        _draw(pixels, regions, points, generator)
        marks.append(points)
    landmarks = np.array(marks).reshape(-1, 81, 2)
    return MarkedPicture(pixels, regions, landmarks, np.ones(landmarks.shape[:2], bool))


def _draw(pixels, regions, points, generator):
    colours = generator.integers(0, 256, (5, 3))
    hull = cv2.convexHull(points.astype(np.float32))[:, 0]
    shapes = [(hull, Region.SKIN, colours[0])]
    shapes += [(points[list(part)], Region.BROWS, colours[1]) for part in (BROW_LEFT, BROW_RIGHT)]
    shapes += [(points[list(part)], Region.EYES, np.array([250, 250, 250])) for part in (EYE_LEFT, EYE_RIGHT)]
    shapes += [(points[list(LIPS)], Region.LIPS, colours[2]), (points[list(LIPS_INSIDE)], Region.MOUTH, colours[3])]
    shapes += [(points[[30, 31, 33, 35]], Region.NOSE, colours[4])]
    for polygon, region, colour in shapes:
        corners = [np.rint(polygon).astype(np.int32)]
        cv2.fillPoly(pixels, corners, colour.tolist(), cv2.LINE_AA)
        cv2.fillPoly(regions, corners, int(region))


class DrawnPictures:
    """Pictures with truth, as trainings take them."""

    def __init__(self, shape, count, seed):
        generator = np.random.default_rng(seed)
        self.pictures = [drawn_picture(shape, generator, faces=(1, 1, 2, 0)[k % 4]) for k in range(count)]
        self.numbers = range(count)
        self.faces = [(n, k) for n, picture in enumerate(self.pictures) for k in range(len(picture.landmarks))]

    def marked(self, number):
        return self.pictures[number]

    def landmarks(self):
        return np.array([self.pictures[number].landmarks[place] for number, place in self.faces])


def write_drawn_set(folder, shape, count, seed, **entries):
    """Write a folder of pictures as `caricli dataset pictures` does: people 0 to 9, of whom 8 validate and 9 tests.

    entries: more of the manifest.
    """
    folder.mkdir()
    writer = PictureWriter(folder)
    generator = np.random.default_rng(seed)
    for number in range(count):
        picture = drawn_picture(shape, generator, faces=(1, 1, 2, 0)[number % 4])
        faces = [_row(points, 8 + number % 2 if number % 8 > 3 else 0) for points in picture.landmarks]
        writer.add(encode_picture(picture.pixels), encode_labels(picture.regions), "flat", faces)
    splits = {"train": list(range(8)), "validation": [8], "test": [9]}
    writer.finish({"command": "drawn", "seed": seed, "splits": splits, **entries})
    return folder


def _row(points, person):
    """A face's row of the truth."""
    zeros = {"expression": 0, "level": 0, "translation": np.zeros(2), "perspective": 0.0, "light": np.zeros((9, 3))}
    own = {"landmarks": points, "visible": np.ones(81, bool), "person": person, "rotation": np.eye(3), "scale": 1.0}
    return {**own, **zeros, "coefficients": np.zeros(4)}
