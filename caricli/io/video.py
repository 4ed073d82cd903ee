"""Moving pictures: MP4 through ffmpeg, GIF through Pillow.

ffmpeg is the program that imageio-ffmpeg brings, or the one that IMAGEIO_FFMPEG_EXE names. It runs as a process of its
own: it is under the GPL, and nothing of it is linked with caricli.
"""

import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import OutputError, shown
from caricli.io.outputs import writing

VIDEO_SUFFIXES = (".mp4", ".gif")
_RATES = {".mp4": (0.001, 240), ".gif": (0.002, 50)}
"""Least and most frames a second: players take a slower MP4 for a fast one, a GIF keeps a frame 655 seconds at most,
and browsers show those that are shorter than two hundredths for a tenth of a second."""
_LONGEST = 65535  # hundredths of a second that a GIF can keep a frame
_MOST_COLOURS = 256  # of a frame of a GIF


def write_video(path: str | Path, frames: Iterable[np.ndarray], fps: float) -> tuple[int, int]:
    """Write a video; of an MP4 an odd width or height is made even by repeating the last column or row.

    Frames are taken one at a time; an MP4 keeps none of them, a GIF its own, each with its palette. An MP4 is H.264 as
    browsers play it (yuv420p, BT.709, its index first).
    path: ends in .mp4 or .gif. frames: (H,W,3) uint8 RGB of one size. fps: frames a second, see ``check_video``.
    Returns width and height of its frames.
    Raises OutputError as ``check_video``, when there is no frame, the sizes differ, no encoder can be opened, or the
    file cannot be written.
    """
    check_video(path, fps)
    checked = _checked(frames, path)
    is_gif = Path(path).suffix.lower() == ".gif"
    if not is_gif:
        checked = map(_even, checked)
    first = next(checked, None)
    if first is None:
        raise OutputError(f"{shown(path)}: expected at least one frame, found none")
    with writing(path):
        if is_gif:
            _write_gif(path, chain([first], checked), fps)
        else:
            _write_mp4(path, chain([first], checked), first.shape, fps)
    return first.shape[1], first.shape[0]


def check_video(path: str | Path, fps: float) -> None:
    """Refuse a video that cannot be, before its frames are drawn.

    path: ends in .mp4 or .gif. fps: frames a second, from 0.001 to 240, for a GIF from 0.002 to 50.
    Raises OutputError when the name ends otherwise, or the rate is none.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in VIDEO_SUFFIXES:
        expected = f"a name that ends in {' or '.join(VIDEO_SUFFIXES)}"
        raise OutputError(f"{shown(path)}: expected {expected}, found {shown(suffix, 20)!r}")
    least, most = _RATES[suffix]
    if not least <= fps <= most:
        expected = f"from {least:g} to {most} frames a second for {suffix}"
        raise OutputError(f"{shown(path)}: expected {expected}, found {fps:g}; give another --fps")


def _even(frame: np.ndarray) -> np.ndarray:
    return np.pad(frame, ((0, frame.shape[0] % 2), (0, frame.shape[1] % 2), (0, 0)), "edge")


def _checked(frames: Iterable[np.ndarray], path: str | Path) -> Iterator[np.ndarray]:
    shape: tuple[int, ...] | None = None
    for frame in frames:
        if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3 or 0 in frame.shape:
            raise OutputError(f"{shown(path)}: expected frames (H,W,3) uint8, found {frame.shape} {frame.dtype}")
        if shape not in (None, frame.shape):
            raise OutputError(f"{shown(path)}: expected frames of one size, found {shape} and {frame.shape}")
        shape = frame.shape
        yield frame


def _write_mp4(path: str | Path, frames: Iterable[np.ndarray], shape: tuple[int, ...], fps: float) -> None:
    # A session of its own, or Ctrl-C would end the encoder before us; without us its input ends, and so does it.
    streams: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL, "start_new_session": True}
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(_encoder(path, shape, fps), stderr=said, **streams) as process:
            try:
                with suppress(BrokenPipeError):  # it ended early, and said why
                    _send(process.stdin, frames)
            except BaseException:
                process.kill()
                raise
        said.seek(0)
        reason = said.read(2000).decode(errors="replace").strip().split("\n")[-1]
    if process.returncode != 0:
        reason = reason or f"it ended with {process.returncode}"
        raise OutputError(f"{shown(path)}: cannot be written: ffmpeg: {shown(reason)}")


def _send(stream: Any, frames: Iterable[np.ndarray]) -> None:
    with stream:
        for frame in frames:
            stream.write(np.ascontiguousarray(frame))


def _encoder(path: str | Path, shape: tuple[int, ...], fps: float) -> list[str]:
    """The command that makes an MP4 of raw RGB frames of a shape (H, W, 3) on its standard input."""
    from imageio_ffmpeg import get_ffmpeg_exe

    try:
        program = get_ffmpeg_exe()
    except RuntimeError as error:
        raise OutputError(f"{shown(path)}: cannot be written: there is no ffmpeg; try .gif ({error})") from error
    frames = f"-f rawvideo -pix_fmt rgb24 -s {shape[1]}x{shape[0]} -r {fps:.9g} -i pipe:0"
    # All of the tags, or players guess by the size of the picture which of the two usual matrices it is.
    tags = "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=bt709"
    picture = f"-vf scale=out_range=tv:out_color_matrix=bt709:flags=accurate_rnd,format=yuv420p,{tags}"
    # One thread, and nothing of the moment in the file: the same frames give the same bytes.
    coding = "-c:v libx264 -preset medium -crf 18 -threads 1 -fflags +bitexact -flags:v +bitexact"
    options = f"-hide_banner -loglevel error -y {frames} {picture} {coding} -movflags +faststart -f mp4"
    return [program, *options.split(), f"file:{path}"]


def _write_gif(path: str | Path, frames: Iterable[np.ndarray], fps: float) -> None:
    following = _gif_pictures(frames, fps)
    first = next(following)
    with open(path, "wb") as stream:
        first.save(stream, "GIF", save_all=True, append_images=following, loop=0, disposal=1)


def _gif_pictures(frames: Iterable[np.ndarray], fps: float) -> Iterator[Any]:
    """Frames as pictures with a palette each, and how long they stay."""
    since = 0
    for k, frame in enumerate(frames):
        # A GIF counts hundredths of a second; rounding each end keeps the whole in time.
        stay = round(100 * (k + 1) / fps) - round(100 * k / fps)
        since += stay
        picture = _with_palette(frame, _MOST_COLOURS)
        if since > _LONGEST:
            # Pillow makes one frame of equal ones, however long this then stays.
            picture = _with_other_pixel(frame)
            since = stay
        picture.info["duration"] = 10 * stay
        yield picture


def _with_palette(frame: np.ndarray, colours: int) -> Any:
    """A frame (H, W, 3) as a picture of so many colours."""
    from PIL import Image

    # Dither would crawl over a face that stands still.
    return Image.fromarray(frame).quantize(colours, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _with_other_pixel(frame: np.ndarray) -> Any:
    """A frame (H, W, 3) as a picture whose first pixel has another blue, by the least that there is."""
    picture = _with_palette(frame, _MOST_COLOURS - 1)
    palette = picture.getpalette()
    red, green, blue = picture.convert("RGB").getpixel((0, 0))
    picture.putpalette([*palette, red, green, blue ^ 1])
    picture.putpixel((0, 0), len(palette) // 3)
    return picture
