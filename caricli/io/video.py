"""Moving pictures: MP4 through OpenCV, GIF through Pillow."""

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import OutputError, shown
from caricli.io.outputs import writing

VIDEO_SUFFIXES = (".mp4", ".gif")
_MAX_GIF_FPS = 50  # shorter frames are shown a tenth of a second by browsers


def write_video(path: str | Path, frames: Iterable[np.ndarray], fps: float) -> None:
    """Write a video; an odd width or height is made even by repeating the last column or row.

    Frames are taken one at a time; an MP4 (MPEG-4 part 2) keeps none of them, a GIF its own, each with its palette.
    path: ends in .mp4 or .gif. frames: (H,W,3) uint8 RGB of one size. fps: frames a second, above 0, for a GIF at most
    50.
    Raises OutputError when the name ends otherwise, the rate is none, there is no frame, the sizes differ, no encoder
    can be opened, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in VIDEO_SUFFIXES:
        raise OutputError(f"{shown(path)}: expected a name that ends in {' or '.join(VIDEO_SUFFIXES)}")
    most = _MAX_GIF_FPS if suffix == ".gif" else 240
    if not 0 < fps <= most:
        expected = f"above 0 and at most {most} frames a second for {suffix}"
        raise OutputError(f"{shown(path)}: expected {expected}, found {fps:g}; give another --fps")
    even = _even(frames, path)
    first = next(even, None)
    if first is None:
        raise OutputError(f"{shown(path)}: expected at least one frame, found none")
    with writing(path):
        if suffix == ".gif":
            _write_gif(path, chain([first], even), fps)
        else:
            _write_mp4(path, chain([first], even), first.shape, fps)


def _even(frames: Iterable[np.ndarray], path: str | Path) -> Iterator[np.ndarray]:
    shape: tuple[int, ...] | None = None
    for frame in frames:
        if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3 or 0 in frame.shape:
            raise OutputError(f"{shown(path)}: expected frames (H,W,3) uint8, found {frame.shape} {frame.dtype}")
        if shape not in (None, frame.shape):
            raise OutputError(f"{shown(path)}: expected frames of one size, found {shape} and {frame.shape}")
        shape = frame.shape
        yield np.pad(frame, ((0, shape[0] % 2), (0, shape[1] % 2), (0, 0)), "edge")


def _write_mp4(path: str | Path, frames: Iterable[np.ndarray], shape: tuple[int, ...], fps: float) -> None:
    import cv2

    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        letters = cv2.VideoWriter_fourcc(*"mp4v")  # type: ignore[attr-defined]  # OpenCV's own stubs lack it
        # MPEG-4 holds rates as fractions of 16 bits.
        writer = cv2.VideoWriter(str(path), letters, round(fps, 2), shape[1::-1])
        if not writer.isOpened():
            raise OutputError(
                f"{shown(path)}: cannot be written: this machine's OpenCV has no MPEG-4 encoder; try .gif"
            )
        try:
            for frame in frames:
                writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
        finally:
            writer.release()
    finally:
        cv2.utils.logging.setLogLevel(level)
    if not Path(path).is_file() or not Path(path).stat().st_size:
        raise OutputError(f"{shown(path)}: cannot be written: OpenCV wrote nothing")


def _write_gif(path: str | Path, frames: Iterable[np.ndarray], fps: float) -> None:
    from PIL import Image

    def pictures() -> Iterator[Any]:
        for k, frame in enumerate(frames):
            # Dither would crawl over a face that stands still.
            picture = Image.fromarray(frame).quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
            # A GIF counts hundredths of a second; rounding each end keeps the whole in time.
            picture.info["duration"] = 10 * (round(100 * (k + 1) / fps) - round(100 * k / fps))
            yield picture

    following = pictures()
    first = next(following)
    with open(path, "wb") as stream:
        first.save(stream, "GIF", save_all=True, append_images=following, loop=0, disposal=1)
