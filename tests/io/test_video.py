import cv2
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


def test_odd_sizes_become_even(tmp_path):
    for name in ("a.mp4", "a.gif"):
        write_video(tmp_path / name, frames(3, 47, 63), 10)
    assert mp4(tmp_path / "a.mp4")[0][0].shape == (48, 64, 3)
    assert Image.open(tmp_path / "a.gif").size == (64, 48)


def test_frames_are_taken_one_at_a_time(tmp_path):
    taken = []

    def watched():
        for k, frame in enumerate(frames()):
            taken.append((k, (tmp_path / "a.mp4").exists()))
            yield frame

    write_video(tmp_path / "a.mp4", watched(), 10)
    assert taken[0] == (0, False) and taken[-1] == (5, True)


def test_rates_that_are_no_fractions_are_written(tmp_path):
    write_video(tmp_path / "a.mp4", frames(), 119.88011988)
    assert mp4(tmp_path / "a.mp4")[1] == pytest.approx(119.88)


def test_what_is_no_video_is_refused_before_a_frame_is_drawn(tmp_path):
    def never():
        raise AssertionError("drawn")
        yield

    for name, fps, words in (
        ("a.avi", 10, "ends in .mp4 or .gif"),
        ("a", 10, "ends in .mp4 or .gif"),
        ("a.mp4", 0, "above 0"),
        ("a.mp4", float("nan"), "above 0"),
        ("a.gif", 60, "at most 50 frames a second for .gif, found 60"),
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
    monkeypatch.setattr(cv2, "VideoWriter_fourcc", lambda *letters: 0x21212121)
    with pytest.raises(OutputError, match="no MPEG-4 encoder"):
        write_video(tmp_path / "a.mp4", frames(), 10)
