"""The style network that comes with caricli, users' own, and the drawings that styles are taken from."""

from pathlib import Path

import cv2
import numpy as np

from caricli.errors import CaricliError, InputError, shown
from caricli.io.image import read_image
from caricli.methods.dynamic.styles import StyleBook, drawn_faces
from caricli.models.style.model import StyleModel, style_from_checkpoint
from caricli.store.bundled import load_bundled
from caricli.store.pictures import pictures_in
from caricli.template.head import load_head

BUNDLED = "style.safetensors"

LARGEST = 512
"""Shorter side, pixels, that drawings keep at most."""

SMALLEST = 2
"""Shorter side, pixels, of a drawing of which strokes can be learnt."""

GENERATED = 64
"""Style pictures that are generated where no drawings are given."""


def load_style(path: Path | None = None) -> StyleModel:
    """Load the style network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, style_from_checkpoint, path)


def load_style_drawings(folder: Path) -> tuple[dict[Path, np.ndarray], list[str]]:
    """The pictures of a folder (H, W, 3) uint8 by path, smaller where they are large, and what is wrong with others.

    Raises InputError when it is no folder, or no picture of it can be read.
    """
    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder of drawings, found none")
    pictures = {}
    notes = []
    for path in pictures_in(folder):
        try:
            pictures[path] = _smaller(_read_drawing(path))
        except CaricliError as error:
            notes.append(f"left out: {error}")
    if not pictures:
        raise InputError(f"{shown(folder)}: expected a folder of drawings, found no picture in it that can be read")
    return pictures, notes


def load_style_book(folder: Path | None, seed: int) -> tuple[StyleBook, list[str]]:
    """A StyleBook of the bundled network, and what is wrong with drawings that are left out.

    folder: of drawings, or None for generated ones. seed: of generated drawings.
    Raises InputError as ``load_style_drawings`` does.
    """
    model = load_style()
    if folder is None:
        return StyleBook(model, drawn_faces(load_head().template(), GENERATED, seed)), []
    pictures, notes = load_style_drawings(folder)
    return StyleBook(model, list(pictures.values())), notes


def _read_drawing(path: Path) -> np.ndarray:
    """A picture (H, W, 3) uint8. Raises InputError where it cannot be read, or is too small to cut a part out of it."""
    picture = read_image(path)
    height, width = picture.shape[:2]
    if min(height, width) < SMALLEST:
        raise InputError(f"{shown(path)}: expected at least {SMALLEST} pixels a side, found {width} x {height}")
    return picture


def _smaller(picture: np.ndarray) -> np.ndarray:
    """A picture whose shorter side is LARGEST at most."""
    height, width = picture.shape[:2]
    scale = LARGEST / min(height, width)
    if scale >= 1:
        return picture
    size = (max(LARGEST, round(scale * width)), max(LARGEST, round(scale * height)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
