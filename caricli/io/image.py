"""Pictures: one loader, one writer."""

import ctypes
import hashlib
import io
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any, TypeVar

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import content_kind, opened, read_bytes
from caricli.io.outputs import writing
from caricli.limits import MAX_IMAGE_BYTES, MAX_IMAGE_PIXELS, MAX_IMAGE_SIDE

EFFORT = 3  # of PNG, from 0 to 9: the usual 6 saves a tenth of the bytes and takes twice as long
_BRIGHT = 230  # of 255: brighter ink is none on white paper
_MOST_PACKED = 4  # that a head wears
_packed: dict[str, bytes] = {}
_packing = Lock()  # files of a head are written beside each other
_WHITES = (1.0, 255.0, 65535.0)  # levels that white has in greys of 32 bits
_OVER = 1.5  # of white: what sharpening and resampling leave of fractions at most
_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "TIFF", "GIF")
_PROFILED = ("RGB", "RGBA", "P", "CMYK")  # modes whose colours a profile says
_Taken = TypeVar("_Taken")
_BEGINNINGS = (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"BM", b"II*\0", b"MM\0*")
_WEBP = slice(8, 12)


def is_image_file(path: str | Path) -> bool:
    """Whether a file begins as a picture that ``read_image`` reads does; one that cannot be read is none."""
    head = b""
    with suppress(InputError), opened(path, "a file") as stream:
        head = stream.read(_WEBP.stop)
    return head.startswith(_BEGINNINGS) or (head.startswith(b"RIFF") and head[_WEBP] == b"WEBP")


def read_image(path: str | Path, any_ink: bool = False, opaque: bool = False) -> np.ndarray:
    """Read a picture as RGB.

    It is turned upright as its EXIF orientation says; colours are turned into those of sRGB where an embedded profile
    says others; transparent pixels are laid over white paper; of an animation the first frame is read; greys of more
    bits, up to 1, 255 or 65535 by how bright they are, are scaled to 8 bits.
    path: a PNG, JPEG, WebP, BMP, TIFF or GIF of at most MAX_IMAGE_PIXELS, at most MAX_IMAGE_SIDE wide or high. any_ink:
    whether transparent pixels are laid over black paper where what is drawn is nearly white. opaque: whether pixels
    keep their colours, however transparent they are.
    Returns (H,W,3) uint8.
    Raises InputError when it is no such picture, damaged, or too large; its size is checked before it is decoded.
    """
    return _decoded(path, lambda image, pillow: _rgb(image, pillow, any_ink, opaque))


def read_alpha(path: str | Path) -> np.ndarray | None:
    """How opaque the pixels of a picture are, (H, W) uint8, or None where the file does not say it.

    path: as in `read_image`, which says what is refused, too; it is turned upright alike.
    """
    return _decoded(path, _alpha)


def check_size(path: str | Path, width: int, height: int) -> None:
    """Raise InputError for a picture of too many pixels, before it is decoded."""
    if width * height > MAX_IMAGE_PIXELS:
        raise InputError(f"{shown(path)}: expected at most {MAX_IMAGE_PIXELS} pixels, found {width} x {height}")
    if max(width, height) > MAX_IMAGE_SIDE:
        side = f"at most {MAX_IMAGE_SIDE} pixels wide and high"
        raise InputError(f"{shown(path)}: expected {side}, found {width} x {height}")


@cache
def _silence_libtiff() -> None:
    """Stop Pillow's libtiff from writing to stderr what is wrong with a file; the error that is raised says it too."""
    from PIL import _imaging

    library = ctypes.CDLL(_imaging.__file__)
    # Missing where Pillow was built without libtiff, or with its symbols hidden.
    with suppress(AttributeError):
        for name in ("TIFFSetErrorHandler", "TIFFSetWarningHandler"):
            setter = getattr(library, name)
            setter.argtypes = [ctypes.c_void_p]
            setter.restype = ctypes.c_void_p
            setter(None)


def write_png(path: str | Path, image: np.ndarray) -> None:
    """Write a PNG.

    image: (H,W,3) or (H,W,4) uint8.
    Raises OutputError when the array is no such image or the file cannot be written.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] not in (3, 4) or 0 in image.shape:
        raise OutputError(f"{shown(path)}: expected an image (H,W,3|4) uint8, found {image.shape} {image.dtype}")
    with writing(path), open(path, "wb") as stream:
        stream.write(png_bytes(image))


def png_bytes(image: np.ndarray) -> bytes:
    """A picture (H, W, 3 or 4) uint8 as a PNG; the same one is packed once, for files and inside of others."""
    from PIL import Image

    image = np.ascontiguousarray(image)
    key = hashlib.sha256(f"{image.shape}".encode() + image.data).hexdigest()
    packed = _packed.get(key)
    if packed is None:
        stream = io.BytesIO()
        Image.fromarray(image).save(stream, "PNG", compress_level=EFFORT)
        packed = stream.getvalue()
        with _packing:
            while len(_packed) >= _MOST_PACKED:
                del _packed[next(iter(_packed))]
            _packed[key] = packed
    return packed


def gray_png(image: np.ndarray) -> bytes:
    """A picture (H, W) uint8 as a PNG."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(stream, "PNG", compress_level=EFFORT)
    return stream.getvalue()


def _decoded(path: str | Path, take: Callable[[Any, Any], _Taken]) -> _Taken:
    """What is taken of a picture that was checked, decoded and turned upright, by a function that also gets Pillow."""
    from PIL import Image, ImageOps

    data = read_bytes(path, MAX_IMAGE_BYTES, "an image")
    _silence_libtiff()
    try:
        # Pillow warns of sizes above a cap of its own; the cap here is lower and refuses.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=_FORMATS) as image:
                width, height = image.size
                check_size(path, width, height)
                image.load()
                with naming(path):
                    return take(ImageOps.exif_transpose(image), Image)
    except InputError:
        raise
    except Image.UnidentifiedImageError:
        kind = content_kind(data) or "another kind of file"
        raise InputError(f"{shown(path)}: expected a PNG, JPEG, WebP, BMP, TIFF or GIF image, found {kind}") from None
    # Pillow's decoders raise whatever they meet (SyntaxError, struct.error, ...); all of it means a damaged file.
    except Exception as error:
        raise InputError(f"{shown(path)}: expected an image, found a damaged one: {shown(error, 120)}") from error


def _rgb(image: Any, pillow: Any, any_ink: bool, opaque: bool) -> np.ndarray:
    if image.mode.startswith("I") or image.mode == "F":
        image = _grey(image, pillow)
    image = _in_srgb(image)
    if image.has_transparency_data and not opaque:
        image = image.convert("RGBA")
        paper = "black" if any_ink and _is_bright(image) else "white"
        image = pillow.alpha_composite(pillow.new("RGBA", image.size, paper), image)
    return np.array(image.convert("RGB"))


def _in_srgb(image: Any) -> Any:
    """A picture in the colours of sRGB where it has others by its profile; one that cannot be read says nothing."""
    from PIL import ImageCms

    embedded = image.info.get("icc_profile")
    if not embedded or image.mode not in _PROFILED:
        return image
    with suppress(OSError, ImageCms.PyCMSError):
        profile = ImageCms.getOpenProfile(io.BytesIO(embedded))
        if not ImageCms.getProfileDescription(profile).startswith("sRGB"):
            if image.mode in ("RGB", "P"):
                image = image.convert("RGBA" if image.has_transparency_data else "RGB")
            mode = "RGBA" if image.mode == "RGBA" else "RGB"
            return ImageCms.profileToProfile(image, profile, ImageCms.createProfile("sRGB"), outputMode=mode)
    return image


def _alpha(image: Any, pillow: Any) -> np.ndarray | None:
    if image.mode.startswith("I") or image.mode == "F":
        image = _grey(image, pillow)
    return np.array(image.convert("RGBA").getchannel("A")) if image.has_transparency_data else None


def _grey(image: Any, pillow: Any) -> Any:
    """A grey picture of more than 8 bits in 8, with its transparency: Pillow clips it to 255 instead of scaling it.

    Raises InputError where nothing says what is white in it.
    """
    values = np.array(image, np.float32)
    np.nan_to_num(values, copy=False)
    white = _WHITES[-1] if image.mode.startswith("I;16") else _white(float(values.max()), image.mode)
    is_clear = values == image.info.get("transparency", -1)
    values *= _WHITES[1] / white
    np.clip(values, 0, 255, out=values)
    grey = values.round(out=values).astype(np.uint8)
    return pillow.fromarray(np.dstack([grey, np.where(is_clear, 0, 255).astype(np.uint8)]))


def _white(most: float, mode: str) -> float:
    """The level of white, of integers (I) or fractions (F) that go up to ``most``; fractions may go a little over."""
    for white in _WHITES[mode == "I" :]:
        if most <= (white if mode == "I" else _OVER * white):
            return white
    raise InputError(f"expected greys up to {_WHITES[0]:g}, {_WHITES[1]:g} or {_WHITES[2]:g}, found {most:g}")


def _is_bright(image: Any) -> bool:
    """Whether what is drawn on an RGBA picture, and covers less than half of it, cannot be told from white paper."""
    brightness, alpha = np.moveaxis(np.asarray(image.convert("LA"), np.float32), 2, 0)
    return bool(0 < alpha.mean() < 128 and (brightness * alpha).sum() > _BRIGHT * alpha.sum())
