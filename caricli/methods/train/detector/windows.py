"""Windows of pictures that a detector is trained on: cut out anywhere, at any scale and turn, bent and mirrored."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.train.detector.distort_picture import DistortSettings, distort_picture
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import FaceFrame, MarkedPicture, turn_axes
from caricli.structures.landmarks import MIRRORED
from caricli.structures.parsing import BEYOND

SMALLEST = 16.0
LARGEST = 128.0
"""Sides of the faces that are to be found in a window of 128 pixels."""


@dataclass(frozen=True)
class WindowSettings:
    """How windows are drawn.

    share: of the window's side to the face's, between; wide: the same of one in ``wide_part``. shift: deviation of the
    face's centre, of its side. turn: deviation of its roll, radians; upside_down: how many of the windows of any part
    are turned by any angle. stretch: deviation of what a linear map changes. bend: deviation of what a smooth one
    moves, of the window's side, in ``bent`` of the windows. distorted: in how many of them a
    face is distorted; distort: how. cut: how many pictures end within the face. whole: least longer side of the whole
    picture in a window of any part, of the window's.
    """

    share: tuple[float, float] = (1.35, 1.95)
    wide: tuple[float, float] = (1.95, 3.0)
    wide_part: float = 0.15
    shift: float = 0.08
    turn: float = 0.15
    upside_down: float = 0.15
    stretch: float = 0.06
    bend: float = 0.02
    bent: float = 0.1
    distorted: float = 0.5
    distort: DistortSettings = DistortSettings()
    cut: float = 0.1
    whole: float = 0.7


def face_window(
    picture: MarkedPicture, face: int, size: int, settings: WindowSettings, generator: np.random.Generator
) -> MarkedPicture:
    """Cut a face out nearly as it is when its landmarks are looked for.

    face: its number. size: of the window, pixels. Returns the window with this face first.
    """
    order = [face, *(k for k in range(len(picture.landmarks)) if k != face)]
    picture = replace(picture, landmarks=picture.landmarks[order], visible=picture.visible[order])
    if generator.random() < settings.distorted:
        picture = distort_picture(picture, 0, settings.distort, generator)
    if generator.random() < settings.cut:
        picture = _cut(picture, generator)
    frame = FaceFrame.of(picture.landmarks[0])
    share = generator.uniform(*(settings.wide if generator.random() < settings.wide_part else settings.share))
    centre = frame.centre + settings.shift * frame.side * generator.normal(size=2)
    frame = FaceFrame(centre, frame.side, frame.roll + settings.turn * generator.normal())
    matrix = frame.matrix(size, share)
    stretch = np.eye(2) + settings.stretch * generator.normal(size=(2, 2))
    return _window(picture, around_middle(stretch, size) @ np.vstack([matrix, [0, 0, 1]]), size, settings, generator)


def any_window(
    picture: MarkedPicture, size: int, settings: WindowSettings, generator: np.random.Generator
) -> MarkedPicture:
    """Cut a part of a picture out, at any scale at which faces are looked for in it; there may be none in it."""
    height, width = picture.regions.shape
    smallest = settings.whole * size / max(height, width)
    scale = smallest * np.exp(generator.uniform(0, 1.3))
    middle = generator.uniform(size=2) * [width, height]
    if len(picture.landmarks) and generator.random() < 0.7:
        face = int(generator.integers(len(picture.landmarks)))
        if generator.random() < settings.distorted:
            picture = distort_picture(picture, face, settings.distort, generator)
        frame = FaceFrame.of(picture.landmarks[face])
        range_of_sides = np.log(np.array([SMALLEST, LARGEST]) * size / 128)
        scale = max(smallest, np.exp(generator.uniform(*range_of_sides)) / frame.side)
        middle = frame.centre + generator.uniform(-0.5, 0.5, 2) * size / scale
    turn = settings.turn * generator.normal()
    if generator.random() < settings.upside_down:
        turn = generator.uniform(-np.pi, np.pi)
    linear = scale * turn_axes(turn) @ (np.eye(2) + settings.stretch * generator.normal(size=(2, 2)))
    matrix = np.column_stack([linear, (size - 1) / 2 - linear @ middle])
    return _window(picture, matrix, size, settings, generator)


def _window(
    picture: MarkedPicture, matrix: np.ndarray, size: int, settings: WindowSettings, generator: np.random.Generator
) -> MarkedPicture:
    """The part of a picture that an affine map (2, 3) leads to; half are mirrored, some bent."""
    if generator.random() < 0.5:
        matrix = mirrored(matrix, size)
    window = moved_window(picture, matrix, size)
    if generator.random() >= settings.bent:
        return window
    return bent_window(window, random_bend(size, settings.bend, generator))


def mirrored(matrix: np.ndarray, size: int) -> np.ndarray:
    """(2, 3) an affine map to a window of so many pixels, and then to its mirror image."""
    return np.array([[-1, 0], [0, 1]]) @ matrix + [[0, 0, size - 1], [0, 0, 0]]


def moved_window(picture: MarkedPicture, matrix: np.ndarray, size: int) -> MarkedPicture:
    """The part of a picture that an affine map (2, 3) leads to; where it mirrors, landmarks change their names."""
    import cv2

    pixels = cut_window(picture.pixels, matrix, (size, size))
    regions = cv2.warpAffine(
        picture.regions,
        matrix,
        (size, size),
        flags=cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(BEYOND,),
    )
    order = list(MIRRORED) if np.linalg.det(matrix[:, :2]) < 0 else slice(None)
    points = (picture.landmarks @ matrix[:, :2].T + matrix[:, 2])[:, order]
    return MarkedPicture(pixels, regions, points, picture.visible[:, order])


def around_middle(linear: np.ndarray, size: int) -> np.ndarray:
    """(2, 3) a linear map (2, 2) that leaves the middle of a window in its place."""
    middle = np.full(2, (size - 1) / 2)
    return np.column_stack([linear, middle - linear @ middle])


def random_bend(size: int, bend: float, generator: np.random.Generator) -> np.ndarray:
    """(S, S, 2) pixels to the places where a window of so many is taken from.

    bend: standard deviation, of the window's side, at the knots of a smooth surface.
    """
    import cv2

    knots = bend * size * generator.normal(size=(5, 5, 2))
    return cv2.resize(knots.astype(np.float32), (size, size), interpolation=cv2.INTER_CUBIC)


def bent_window(window: MarkedPicture, moved: np.ndarray) -> MarkedPicture:
    """A window taken from elsewhere. moved: (S, S, 2) of ``random_bend``."""
    import cv2

    size = len(window.regions)
    x, y = np.meshgrid(np.arange(size, dtype=np.float32), np.arange(size, dtype=np.float32))
    maps = (x + moved[..., 0], y + moved[..., 1])
    pixels = cv2.remap(window.pixels, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    regions = cv2.remap(window.regions, *maps, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    return replace(window, pixels=pixels, regions=regions, landmarks=bent_places(window.landmarks, moved))


def bent_places(points: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Where points (..., 2) of a window, NaN where unknown, are in the bent one."""
    # What is at p comes from p + moved(p); two steps find where a point went.
    places = points
    for _ in range(2):
        cells = np.clip(np.rint(np.nan_to_num(places)), 0, len(moved) - 1).astype(int)
        places = points - moved[cells[..., 1], cells[..., 0]]
    return places


def _cut(picture: MarkedPicture, generator: np.random.Generator) -> MarkedPicture:
    """The picture as if it ended within the first face, on one side of it."""
    low = picture.landmarks[0].min(0)
    high = picture.landmarks[0].max(0)
    height, width = picture.regions.shape
    limits = np.array([0, 0, width, height])
    side = generator.integers(4)
    axis = side % 2
    depth = generator.uniform(0, 0.35) * (high - low)[axis]
    limits[side] = round(low[axis] + depth) if side < 2 else round(high[axis] - depth)
    limits = np.clip(limits, 0, [width - 1, height - 1, width, height])
    if limits[2] - limits[0] < 16 or limits[3] - limits[1] < 16:
        return picture
    part = (slice(limits[1], limits[3]), slice(limits[0], limits[2]))
    points = picture.landmarks - limits[:2]
    inside = ((points >= -0.5) & (points <= limits[2:] - limits[:2] - 0.5)).all(-1)
    return MarkedPicture(picture.pixels[part], picture.regions[part], points, picture.visible & inside)
