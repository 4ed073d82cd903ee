"""Face parsing: a picture of label numbers, with a legend."""

import io
import warnings
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.files import read_bytes
from caricli.io.image import EFFORT, check_size
from caricli.io.outputs import writing
from caricli.io.strict_json import format_json, parse_json, read_json
from caricli.limits import MAX_IMAGE_BYTES

SCHEMA = "caricli.parsing/1"

CELEBAMASK_HQ = {
    name: number for number, name in enumerate(
        "background skin nose eye_glasses eye_left eye_right brow_left brow_right ear_left ear_right mouth upper_lip "
        "lower_lip hair hat earring necklace neck cloth".split()
    )
}  # fmt: skip
"""Label numbers of CelebAMask-HQ, by the names used here; left and right are the picture's."""


def read_parsing(path: str | Path) -> tuple[np.ndarray, dict[str, int]]:
    """Read a label map.

    path: a PNG of one byte a pixel, grey or with a palette, or as painting programs write it, opaque and with red,
    green and blue alike; the JSON beside it, of the same stem, names its labels:
    `{"schema": "caricli.parsing/1", "labels": {"skin": 1, ...}}`, or else the text of its own that is called by that
    schema. Without either they are CelebAMask-HQ's.
    Returns (H,W) uint8, and the numbers of the labels by their names.
    Raises InputError when it is no such picture, too large, or the legend is malformed.
    """
    labels, own = _numbers_and_text(path)
    beside = Path(path).with_suffix(".json")
    if beside.is_file():
        return labels, read_legend(beside)["labels"]
    if own is None:
        return labels, dict(CELEBAMASK_HQ)
    return labels, _checked_legend(parse_json(str(own).encode(), path), path)["labels"]


def names_labels(path: str | Path) -> bool:
    """Whether a label map, or the JSON beside it, names its labels. Raises InputError when it is no such picture."""
    return Path(path).with_suffix(".json").is_file() or _numbers_and_text(path)[1] is not None


def _numbers_and_text(path: str | Path) -> tuple[np.ndarray, Any]:
    """(H, W) uint8 of a label map, and the text in it that names its labels, or None."""
    from PIL import Image, UnidentifiedImageError

    data = read_bytes(path, MAX_IMAGE_BYTES, "a label map")
    try:
        # Pillow warns of sizes above a cap of its own; the cap here is lower and refuses.
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            check_size(path, *image.size)
            labels = _numbers(image)
            if labels is None:
                kind = f"{image.width} x {image.height} of mode {image.mode}"
                expected = "a PNG of label numbers, one byte a pixel or grey"
                raise InputError(f"{shown(path)}: expected {expected}, found {kind}")
            return labels, image.info.get(SCHEMA)
    except InputError:
        raise
    except UnidentifiedImageError:
        raise InputError(f"{shown(path)}: expected a PNG of label numbers, found another kind of file") from None
    except Exception as error:  # Pillow's decoders raise whatever they meet
        raise InputError(f"{shown(path)}: expected a PNG of label numbers, found none: {shown(error, 120)}") from error


def _numbers(image: Any) -> np.ndarray | None:
    """(H, W) uint8 of a PNG of numbers, or of opaque greys; None for another."""
    if image.mode in ("L", "P", "1"):
        return np.array(image).astype(np.uint8)
    if image.mode not in ("RGB", "RGBA", "LA"):
        return None
    pixels = np.array(image)
    is_opaque = not image.mode.endswith("A") or (pixels[..., -1] == 255).all()
    colours = pixels[..., :3] if image.mode.startswith("RGB") else pixels[..., :1]
    return colours[..., 0].copy() if is_opaque and (colours == colours[..., :1]).all() else None


def write_parsing(path: str | Path, labels: np.ndarray, names: type[IntEnum] | None = None) -> None:
    """Write a label map.

    labels: (H, W) uint8. names: of the labels, which the picture then tells itself.
    Raises OutputError when the file cannot be written.
    """
    from PIL import Image, PngImagePlugin

    own = PngImagePlugin.PngInfo()
    if names is not None:
        own.add_text(SCHEMA, format_json(legend(names), path, indent=None))
    with writing(path), open(path, "wb") as stream:
        Image.fromarray(labels).save(stream, "PNG", compress_level=EFFORT, pnginfo=own)


def legend(labels: type[IntEnum], **more: Any) -> dict[str, Any]:
    """The JSON that goes beside a label map: the names of its labels, and more entries."""
    return {"schema": SCHEMA, "labels": {label.name.lower(): label.value for label in labels}} | more


def read_legend(path: str | Path) -> dict[str, Any]:
    """The JSON beside a label map, as ``legend`` gives it. Raises InputError when it is another, or malformed."""
    return _checked_legend(read_json(path), path)


def _checked_legend(value: Any, path: str | Path) -> dict[str, Any]:
    names = value.get("labels") if isinstance(value, dict) and value.get("schema") == SCHEMA else None
    if not isinstance(names, dict) or not all(type(n) is int and 0 <= n < 256 for n in names.values()):
        raise InputError(f"{shown(path)}: expected schema {SCHEMA!r} and labels from 0 to 255, found another JSON")
    return value


def is_legend(path: str | Path) -> bool:
    """Whether a file is the JSON beside a label map."""
    try:
        return Path(path).suffix.lower() == ".json" and bool(read_legend(path))
    except InputError:
        return False
