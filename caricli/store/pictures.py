"""Pictures that landmarks and faces belong to, by path."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.image import read_image
from caricli.io.landmarks import read_landmarks
from caricli.io.parsing import read_parsing
from caricli.methods.texture.mask_head import mask_head, mesh_pixels
from caricli.structures import Face, Landmarks

PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".gif")

_EYES = ("eye_left", "eye_right")
"""Labels of a parsed picture that show an eye."""

_WHITE = 127
"""Grey above which a pixel of a mask is white."""


def find_picture(image: Path | None, path: Path, many: bool) -> Path | None:
    """The picture of a landmark file: the given one, or where there are many, that of its name in a folder.

    image: path of a picture, or of a folder of pictures, or None. path: of the landmarks.
    Raises InputError where many inputs share one picture, and where the folder has none of the name.
    """
    if image is None or not many:
        return image
    if not image.is_dir():
        raise InputError(f"{image}: expected a folder of pictures, because results of many inputs were asked for")
    pictures = [image / f"{path.stem}{suffix}" for suffix in PICTURES if (image / f"{path.stem}{suffix}").is_file()]
    if not pictures:
        raise InputError(f"{image}: expected a picture named {path.stem} with one of {', '.join(PICTURES)}")
    return pictures[0]


def load_marked_picture(
    path: Path, image: Path | None = None, pts_origin: int = 1
) -> tuple[Landmarks, np.ndarray | None]:
    """Landmarks, and the picture (H, W, 3) uint8 that they belong to, where one is given.

    path: of the landmarks. image: path of the picture. pts_origin: coordinate of the first pixel in .pts files.
    Raises InputError when the landmarks cannot be of such a picture.
    """
    marks = read_landmarks(path, pts_origin)
    if image is None:
        return marks, None
    picture = read_image(image)
    size = (picture.shape[1], picture.shape[0])
    if marks.image_size is not None and tuple(marks.image_size) != size:
        other = "{} x {}".format(*marks.image_size)
        raise InputError(f"{path}: expected landmarks of the {size[0]} x {size[1]} picture {image}, found {other}")
    with naming(path):
        return Landmarks(marks.points, size), picture


def load_eyes(path: Path | None, size: tuple[int, int] | None) -> np.ndarray | None:
    """(H, W) bool: pixels that show an eye, by the labels of a parsed picture.

    path: of the labels, or None for no such picture. size: (width, height) that it must have, or None for any.
    Raises InputError for another size, and where no pixel is labelled so.
    """
    if path is None:
        return None
    labels, legend = read_parsing(path)
    if size is not None and tuple(size) != labels.shape[::-1]:
        other = f"{labels.shape[1]} x {labels.shape[0]}"
        raise InputError(f"{shown(path)}: expected the picture's size, {size[0]} x {size[1]}, found {other}")
    eyes = np.isin(labels, [legend[name] for name in _EYES if name in legend])
    if not eyes.any():
        raise InputError(f"{shown(path)}: expected pixels labelled {' or '.join(_EYES)}, found none")
    return eyes


def load_mask(path: Path | None, image: Path, face: Face, picture: np.ndarray) -> np.ndarray:
    """(H, W) bool: the head in a picture, by a mask file, or cut out by colours.

    path: of the mask, or None. image: path of the picture (H, W, 3). face: Face with camera and landmarks in it.
    Raises InputError when the face is outside, and when mask or picture show no head where it is.
    """
    with naming(image):
        if path is None:
            return mask_head(face, picture)
        pixels = mesh_pixels(face, picture)
    given = read_image(path)
    if given.shape != picture.shape:
        expected, other = (f"{each.shape[1]} x {each.shape[0]}" for each in (picture, given))
        raise InputError(f"{shown(path)}: expected the picture's size, {expected}, found {other}")
    mask = given.mean(2) > _WHITE
    if not (mask & pixels).any():
        raise InputError(f"{shown(path)}: expected white where the head is, found none there")
    return mask
