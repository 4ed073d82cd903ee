import http.server
import json
import os
import queue
import shutil
import signal
import struct
import subprocess
import threading
import warnings
import weakref
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from caricli.errors import OutputError
from caricli.io.video import write_video


def frames(count=6, height=48, width=64):
    """A bright square that moves to the right over a gradient."""
    for k in range(count):
        frame = np.zeros((height, width, 3), np.uint8)
        frame[..., 0] = np.linspace(30, 120, width)
        frame[..., 2] = np.linspace(200, 90, height)[:, None]
        frame[8:24, 4 + 6 * k : 20 + 6 * k] = (250, 240, 60)
        yield frame


def mp4(path):
    reader = cv2.VideoCapture(str(path))
    found = []
    while (got := reader.read())[0]:
        found.append(got[1][..., ::-1])
    return found, reader.get(cv2.CAP_PROP_FPS)


def test_an_mp4_holds_the_frames_in_order_and_colour(tmp_path):
    write_video(tmp_path / "a.mp4", frames(), 25)
    found, fps = mp4(tmp_path / "a.mp4")
    assert len(found) == 6 and fps == 25
    for got, given in zip(found, frames(), strict=True):
        assert np.abs(got.astype(int) - given).mean() < 8


def test_a_gif_holds_the_frames_loops_and_keeps_the_time(tmp_path):
    write_video(tmp_path / "a.gif", frames(), 30)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == 6 and image.info["loop"] == 0
        durations = []
        for k, given in enumerate(frames()):
            image.seek(k)
            durations.append(image.info["duration"])
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - given).mean() < 3
    assert sum(durations) == 200 and set(durations) == {30, 40}


def gif_durations(path):
    """Milliseconds of every frame."""
    durations = []
    with Image.open(path) as image:
        for k in range(image.n_frames):
            image.seek(k)
            durations.append(image.info["duration"])
    return durations


def test_the_slowest_films_keep_their_time(tmp_path):
    write_video(tmp_path / "a.gif", frames(2), 0.002)
    assert gif_durations(tmp_path / "a.gif") == [500_000, 500_000]
    write_video(tmp_path / "a.mp4", frames(2), 0.001)
    assert len(mp4(tmp_path / "a.mp4")[0]) == 2 and mp4(tmp_path / "a.mp4")[1] == pytest.approx(0.001)


@pytest.mark.parametrize("side", [1, 20])
def test_a_gif_that_stands_still_for_long_keeps_the_time(tmp_path, side):
    still = np.random.default_rng(0).integers(0, 256, (side, side, 3), np.uint8)
    write_video(tmp_path / "a.gif", [still] * 27 + [255 - still], 0.02)
    assert gif_durations(tmp_path / "a.gif") == [650_000, 50_000, 600_000, 50_000, 50_000]
    with Image.open(tmp_path / "a.gif") as image:
        for k in range(4):
            image.seek(k)
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - still).mean() < 10


def test_odd_sizes_become_even_where_they_must(tmp_path):
    assert write_video(tmp_path / "a.mp4", frames(3, 47, 63), 10) == (64, 48)
    assert write_video(tmp_path / "a.gif", frames(3, 47, 63), 10) == (63, 47)
    assert mp4(tmp_path / "a.mp4")[0][0].shape == (48, 64, 3)
    assert Image.open(tmp_path / "a.gif").size == (63, 47)


def test_frames_are_taken_one_at_a_time(tmp_path):
    kept = []

    def watched():
        for frame in frames():
            kept.append(weakref.ref(frame))
            assert sum(each() is not None for each in kept) <= 3
            yield frame

    write_video(tmp_path / "a.mp4", watched(), 10)
    assert len(kept) == 6


def test_rates_that_are_no_fractions_are_written(tmp_path):
    write_video(tmp_path / "a.mp4", frames(), 119.88011988)
    assert mp4(tmp_path / "a.mp4")[1] == pytest.approx(119.88, abs=0.001)


def test_what_is_no_video_is_refused_before_a_frame_is_drawn(tmp_path):
    def never():
        raise AssertionError("drawn")
        yield

    for name, fps, words in (
        ("a.avi", 10, "ends in .mp4 or .gif"),
        ("a", 10, "ends in .mp4 or .gif"),
        ("a.mp4", 0, "from 0.001 to 240 frames a second for .mp4, found 0;"),
        ("a.mp4", float("nan"), "found nan"),
        ("a.mp4", 0.0009, "found 0.0009"),
        ("a.gif", 60, "from 0.002 to 50 frames a second for .gif, found 60"),
        ("a.gif", 0.0015, "found 0.0015"),
    ):
        with pytest.raises(OutputError, match=words):
            write_video(tmp_path / name, never(), fps)
    assert not any(tmp_path.iterdir())


def test_bad_frames_and_places_are_one_line(tmp_path):
    with pytest.raises(OutputError, match="at least one frame"):
        write_video(tmp_path / "a.mp4", [], 10)
    with pytest.raises(OutputError, match="uint8"):
        write_video(tmp_path / "a.gif", [np.zeros((4, 4, 3))], 10)
    with pytest.raises(OutputError, match="one size"):
        write_video(tmp_path / "a.mp4", [*frames(1), *frames(1, 24, 24)], 10)
    for suffix in ("gif", "mp4"):
        with pytest.raises(OutputError, match="cannot be written"):
            write_video(tmp_path / "none" / f"a.{suffix}", frames(), 10)


def test_without_an_encoder_it_says_so(tmp_path, monkeypatch):
    def none():
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(OutputError, match=r"a\.mp4: cannot be written: there is no ffmpeg; try \.gif"):
        write_video(tmp_path / "a.mp4", frames(), 10)


def test_a_failing_encoder_is_one_line(tmp_path, monkeypatch):
    program = tmp_path / "ffmpeg"
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(program))
    for body, words in (
        ("echo out of luck >&2; exit 1", "ffmpeg: out of luck"),
        ("cat > /dev/null; exit 3", "ffmpeg: it ended with 3"),
        ("kill -9 $$", "ffmpeg: it ended with -9"),
    ):
        program.write_text(f"#!/bin/sh\n[ $1 = -version ] && exit 0\n{body}\n")
        program.chmod(0o755)
        with pytest.raises(OutputError, match=f"a.mp4: cannot be written: {words}$"):
            write_video(tmp_path / "a.mp4", frames(300, 400, 2000), 10)


def test_an_error_while_drawing_ends_the_encoder(tmp_path):
    def failing():
        yield from frames(3)
        raise ValueError("no more")

    with pytest.raises(ValueError, match="no more"):
        write_video(tmp_path / "a.mp4", failing(), 10)
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()
    assert "ffmpeg" not in {Path(f"/proc/{child}/comm").read_text().strip()[:6] for child in children}


def test_an_mp4_is_h264_that_starts_at_once(tmp_path):
    for name in ("a.mp4", "b.mp4"):
        write_video(tmp_path / name, frames(), 25)
    data = (tmp_path / "a.mp4").read_bytes()
    assert data == (tmp_path / "b.mp4").read_bytes()
    place = 0
    boxes = []
    while place < len(data):
        size, kind = struct.unpack_from(">I4s", data, place)
        boxes.append(kind)
        place += size
    assert boxes.index(b"ftyp") < boxes.index(b"moov") < boxes.index(b"mdat")
    about = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), "-i", tmp_path / "a.mp4"], capture_output=True, text=True
    ).stderr
    assert "Video: h264 (High)" in about and "yuv420p(tv, bt709, progressive" in about, about


# In a browser.

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PAGE = """<!doctype html><video muted></video><script>
const video = document.querySelector("video"), canvas = document.createElement("canvas"), seen = [];
const tell = (value) => fetch("/seen", {method: "POST", body: JSON.stringify(value)});
const look = () => {
  canvas.width = video.videoWidth; canvas.height = video.videoHeight;
  const context = canvas.getContext("2d", {willReadFrequently: true});
  context.drawImage(video, 0, 0);
  const picture = Array.from(context.getImageData(0, 0, canvas.width, canvas.height).data);
  // Events come before their frames do: nothing but zeros at first, then the frame before. No two here are the same.
  if (picture.every((value, k) => value == (seen.length ? seen.at(-1)[k] : 0))) return setTimeout(look, 50);
  seen.push(picture);
  if (seen.length == COUNT) tell({size: [canvas.height, canvas.width], duration: video.duration, pictures: seen});
  else video.currentTime = (seen.length + 0.5) / FPS;
};
video.onerror = () => tell(video.error.message);
video.onloadeddata = video.onseeked = look;
// Browsers seek only in what they have whole, or from servers that can send parts.
fetch("/film.mp4").then((answer) => answer.blob()).then((film) => { video.src = URL.createObjectURL(film); });
</script>"""


@pytest.fixture
def browse(tmp_path):
    """Play an MP4 in Chromium; returns what its page saw: a dict, or the message of what went wrong."""
    if CHROMIUM is None:
        warnings.warn("Chromium is not installed: NOBODY HAS CHECKED THAT BROWSERS PLAY OUR FILMS", stacklevel=1)
        pytest.skip("Chromium is not installed")

    def play(film, count, fps):
        seen = queue.Queue()
        page = PAGE.replace("FPS", str(fps)).replace("COUNT", str(count)).encode()

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                body = {"/": page, "/film.mp4": film.read_bytes()}.get(self.path, b"")
                self.send_response(200 if body else 404)
                self.send_header("Content-Type", "video/mp4" if self.path == "/film.mp4" else "text/html")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def do_POST(self):
                seen.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            options = "--headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run".split()
            command = [CHROMIUM, *options, f"--user-data-dir={tmp_path / 'profile'}"]
            command.append(f"http://127.0.0.1:{server.server_port}/")
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
            with subprocess.Popen(command, **quiet) as browser:
                try:
                    return seen.get(timeout=60)
                finally:
                    os.killpg(browser.pid, signal.SIGKILL)
                    server.shutdown()

    return play


def test_a_browser_plays_it_in_its_colours(browse, tmp_path):
    write_video(tmp_path / "a.mp4", frames(6, 47, 63), 10)
    seen = browse(tmp_path / "a.mp4", 6, 10)
    assert isinstance(seen, dict), seen
    assert seen["size"] == [48, 64] and seen["duration"] == pytest.approx(0.6)
    for k, (got, given) in enumerate(zip(seen["pictures"], frames(6, 47, 63), strict=True)):
        picture = np.reshape(got, (48, 64, 4))[:47, :63, :3]
        assert np.abs(picture - given.astype(int)).mean() < 6
        # The other usual matrix makes the square greener by 11. Chromium itself rounds its blue by up to 9.
        square = picture[12:20, 8 + 6 * k : 16 + 6 * k].mean((0, 1))
        assert (np.abs(square - [250, 240, 60]) < [4, 4, 10]).all(), square


def test_the_browser_refuses_what_it_cannot_play(browse, tmp_path):
    path = tmp_path / "old.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 10, (64, 48))
    for frame in frames():
        writer.write(frame)
    writer.release()
    assert isinstance(browse(path, 6, 10), str)
