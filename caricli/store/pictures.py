"""Pictures that landmarks and faces belong to, by path."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.image import is_image_file, read_alpha, read_image
from caricli.io.landmarks import read_landmarks
from caricli.io.parsing import names_labels, read_parsing
from caricli.structures import Landmarks
from caricli.structures.landmarks import MOUTH
from caricli.structures.parsing import Region

PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".gif")

MARKS = (".json", ".pts", ".txt", ".npy")
"""Suffixes of landmark files; where a picture has several, the first that holds landmarks counts."""

_EYE_LABELS = ("eye_left", "eye_right", "eyes")
"""Labels of a parsed picture that show an eye."""

_ELSEWHERE = {
    "eye_glasses": Region.GLASSES,
    "earring": Region.OTHER,
    "necklace": Region.OTHER,
    **{f"eye_{side}": Region.EYES for side in ("left", "right")},
    **{f"brow_{side}": Region.BROWS for side in ("left", "right")},
    **{f"ear_{side}": Region.EARS for side in ("left", "right")},
    **{f"{side}_lip": Region.LIPS for side in ("upper", "lower")},
}
"""What the labels are here that CelebAMask-HQ calls otherwise."""

_LOOKS = ("eye_glasses", "eye_left", "eye_right", "brow_left", "brow_right")
_BELOW = 1 / 3
"""Share of a mouth's landmarks that lie on eyes and brows where labels are numbered in another way, at least. By the
numbers that `caricli detect` writes 0.55 to 1 do on the caricatures, by the right ones none."""

_WHITE = 127
"""Grey above which a pixel of a mask is white, and alpha above which it is opaque."""


def pictures_in(folder: Path) -> list[Path]:
    """The pictures of a folder, by their names; hidden files, such as what macOS keeps beside pictures, are none."""
    seen = (path for path in folder.iterdir() if not path.name.startswith("."))
    return sorted(path for path in seen if path.suffix.lower() in PICTURES and path.is_file())


def marks_beside(picture: Path) -> Path | None:
    """The landmark file beside a picture, or None; other files may have its name."""
    return next(filter(_holds_landmarks, map(picture.with_suffix, MARKS)), None)


def _holds_landmarks(file: Path) -> bool:
    """Whether a file is there and says where landmarks are."""
    try:
        status = file.stat()
    except OSError:
        return False
    return _says_landmarks(file, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=1 << 16)
def _says_landmarks(file: Path, _changed: int, _size: int) -> bool:
    try:
        read_landmarks(file)
    except InputError:
        return False
    return True


def find_picture(image: Path | None, path: Path, name: str | None) -> Path | None:
    """The picture of a landmark file: the given one, or where there are many, that of its name in a folder.

    image: path of a picture, or of a folder of pictures, or None. path: of the landmarks; one that is a picture itself
    has none in the folder. name: that tells the file from the others, or None where there is one alone.
    Raises InputError where many inputs share one picture, and where the folder has none of the name.
    """
    if image is None or name is None:
        return image
    if is_image_file(path):
        return None
    if not image.is_dir():
        raise InputError(
            f"{shown(image)}: expected a folder of pictures, because results of many inputs were asked for"
        )
    pictures = [picture for picture in pictures_in(image) if picture.stem == name]
    if not pictures:
        raise InputError(f"{shown(image)}: expected a picture named {shown(name)} with one of {', '.join(PICTURES)}")
    return min(pictures, key=lambda picture: PICTURES.index(picture.suffix.lower()))


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
        own = f"{size[0]} x {size[1]} picture {shown(image)}"
        raise InputError(f"{shown(path)}: expected landmarks of the {own}, found {other}")
    with naming(path):
        return replace(marks, image_size=size), picture


def load_found_marks(
    path: Path, count: int, image: Path | None = None, pts_origin: int = 1
) -> tuple[Landmarks, np.ndarray | None]:
    """``load_marked_picture``; of landmarks with spreads, which were found, those beyond the mesh's are left out.

    count: landmarks that the mesh has.
    """
    marks, picture = load_marked_picture(path, image, pts_origin)
    return (marks if marks.spreads is None else marks.first(count)), picture


def load_eyes(path: Path | None, size: tuple[int, int] | None, points: np.ndarray | None = None) -> np.ndarray | None:
    """(H, W) bool: pixels that show an eye, by the labels of a parsed picture.

    path: of the labels, or None for no such picture. size: (width, height) that it must have, or None for any. points:
    (L, 2) pixels, landmarks of its face, NaN where unknown, or None.
    Raises InputError for another size, where no pixel is labelled so, and as ``load_regions`` does for numbers.
    """
    if path is None:
        return None
    labels, legend = _load_labels(path, size, points)
    eyes = np.isin(labels, [legend[name] for name in _EYE_LABELS if name in legend])
    if not eyes.any():
        raise InputError(f"{shown(path)}: expected pixels labelled {' or '.join(_EYE_LABELS)}, found none")
    return eyes


def load_mask(path: Path, size: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: where a mask is white, or where it is opaque if parts of it are transparent.

    path: of the mask. size: (width, height) of the picture that it is of.
    Raises InputError for another size, and where the mask is one all over.
    """
    mask = read_image(path)
    _check_size(path, mask, size)
    alpha = read_alpha(path)
    colour = "white"
    head = mask.mean(2) > _WHITE
    if alpha is not None and alpha.min() < alpha.max():
        colour = "opaque"
        head = alpha > _WHITE
    if head.all() or not head.any():
        where = f"all of it {colour}" if head.all() else "none there"
        raise InputError(f"{shown(path)}: expected a mask that is {colour} where the head is, found {where}")
    return head


def load_regions(path: Path, size: tuple[int, int], points: np.ndarray | None = None) -> np.ndarray:
    """(H, W) uint8 values of Region: what a picture shows, by its label map.

    path: of the labels. size: (width, height) of the picture that they are of. points: (L, 2) pixels, landmarks of its
    face, NaN where unknown, or None.
    Raises InputError for another size, for a label whose number or name says nothing here, where all is background, and
    where nothing names the labels and the mouth lies on eyes by the numbers of CelebAMask-HQ.
    """
    labels, legend = _load_labels(path, size, points)
    regions = np.full(256, -1)
    for name, number in legend.items():
        region = _ELSEWHERE.get(name, Region.__members__.get(name.upper()))
        if region is None and (labels == number).any():
            raise InputError(f"{shown(path)}: expected labels such as hair or skin, found {shown(name)!r}")
        regions[number] = -1 if region is None else region
    unnamed = labels[regions[labels] < 0]
    if len(unnamed):
        raise InputError(f"{shown(path)}: expected numbers that the legend names, found {unnamed[0]}")
    shown_there = regions[labels].astype(np.uint8)
    if not shown_there.any():
        raise InputError(f"{shown(path)}: expected pixels that show a head, found background alone")
    return shown_there


def _load_labels(
    path: Path, size: tuple[int, int] | None, points: np.ndarray | None
) -> tuple[np.ndarray, dict[str, int]]:
    """(H, W) labels and the numbers of their names. size, points: as of ``load_eyes``."""
    labels, legend = read_parsing(path)
    _check_size(path, labels, size)
    if points is not None and not names_labels(path):
        mouth = points[list(MOUTH)]
        columns, rows = np.round(mouth[np.isfinite(mouth).all(axis=1)]).astype(int).T
        inside = (columns >= 0) & (rows >= 0) & (columns < labels.shape[1]) & (rows < labels.shape[0])
        there = labels[rows[inside], columns[inside]]
        if len(there) and np.isin(there, [legend[name] for name in _LOOKS]).mean() > _BELOW:
            raise InputError(
                f"{shown(path)}: expected labels numbered as in CelebAMask-HQ, as nothing names them, found eyes or "
                f"brows where the mouth is; put its JSON beside it, {shown(path.with_suffix('.json').name)}"
            )
    return labels, legend


def _check_size(path: Path, pixels: np.ndarray, size: tuple[int, int] | None) -> None:
    """Raise InputError where a picture beside another has not its size (width, height); None is any."""
    if size is not None and tuple(size) != (pixels.shape[1], pixels.shape[0]):
        other = f"{pixels.shape[1]} x {pixels.shape[0]}"
        raise InputError(f"{shown(path)}: expected the picture's size, {size[0]} x {size[1]}, found {other}")
