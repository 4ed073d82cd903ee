"""Many pictures on one sheet."""

import unicodedata
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.render.backdrop import PAPER, on_backdrop

_GAP = 0.03  # of a cell's shorter side, between cells
_TEXT = 0.06  # of a cell's shorter side, height of the letters
_INK = (70, 68, 66)
_STRIP = 1.6  # of the letters' height, of the strip they stand in
_SPELT = str.maketrans({"ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "Ae", "–": "-", "—": "-"})


def contact_sheet(
    images: Sequence[np.ndarray],
    columns: int | None = None,
    labels: Sequence[str] | None = None,
) -> np.ndarray:
    """Lay pictures out in rows, each centred in a cell of the largest one's size, with a label under it.

    images: list of (H, W, 3 or 4) uint8. columns: pictures in a row; near to a square sheet when absent. labels: one
    text per picture, shortened to fit.
    Returns (H, W, 3) uint8.
    Raises InputError when there is no picture, or not one label for each.
    """
    if not len(images):
        raise InputError("a contact sheet needs at least one picture, found none")
    if labels is not None and len(labels) != len(images):
        raise InputError(f"a contact sheet of {len(images)} pictures needs as many labels, found {len(labels)}")
    height, width = (max(image.shape[k] for image in images) for k in (0, 1))
    columns = min(columns or int(np.ceil(np.sqrt(len(images) * height / width))), len(images))
    rows = -(-len(images) // columns)
    gap = max(2, round(_GAP * min(width, height)))
    size = max(10, round(_TEXT * min(width, height)))
    strip = 0 if labels is None else round(_STRIP * size)
    sheet = np.empty((gap + rows * (height + strip + gap), gap + columns * (width + gap), 3), np.uint8)
    sheet[:] = PAPER
    for k, image in enumerate(images):
        top = gap + (k // columns) * (height + strip + gap)
        left = gap + (k % columns) * (width + gap)
        y = top + (height - image.shape[0]) // 2
        x = left + (width - image.shape[1]) // 2
        sheet[y : y + image.shape[0], x : x + image.shape[1]] = on_backdrop(image)
        if labels is not None:
            cell = sheet[top + height : top + height + strip, left : left + width]
            cell[:] = _labelled(cell, labels[k], size)
    return sheet


def legible(text: str) -> str:
    """A text in the letters that pictures are labelled with, which are those of English: ö is o there, ж a question."""
    plain = unicodedata.normalize("NFKD", text.translate(_SPELT))
    return "".join(c if c.isascii() and c.isprintable() else "?" for c in plain if not unicodedata.combining(c))


@cache
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)


def _labelled(strip: np.ndarray, text: str, size: int) -> np.ndarray:
    """Write one line of text in the middle of a strip."""
    from PIL import Image, ImageDraw

    font = _font(size)
    text = legible(str(text))
    if font.getlength(text) > strip.shape[1]:
        while text and font.getlength(text + "...") > strip.shape[1]:
            text = text[:-1]
        text += "..."
    picture = Image.fromarray(np.ascontiguousarray(strip))
    ImageDraw.Draw(picture).text((strip.shape[1] / 2, strip.shape[0] / 2), text, _INK, font, anchor="mm")
    return np.asarray(picture)
