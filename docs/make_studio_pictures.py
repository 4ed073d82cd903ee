"""Draw a face in the studio as a person would, and keep what is seen: make_studio_pictures.py OUT [--speed PIXELS].

OUT gets the pictures of docs/studio.md and of the README, the rig that was made, and seconds.json: how long it took
from the command to every step, by a hand that draws so many pixels of the screen a second and rests between strokes.
"""

import argparse
import io
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = (1280, 720)
REST = 0.7
"""Seconds between strokes."""

STEP = 6
"""Pixels of the screen that a hand moves at once."""

GIF = (640, 90)
"""Pixels of width, and milliseconds of a frame."""

SHOWN = "+(document.querySelector('.caricli-head canvas')?.dataset.shown || 0)"
"""Number of the head that is seen."""


def arc(middle, radii, turns):
    """A piece of an oval. middle, radii: pixels of a canvas of 512. turns: its ends, from the right over the bottom."""
    angles = 2 * np.pi * np.linspace(*turns, 40)
    return np.array(middle) + np.array(radii) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def caricature():
    """Its lines: a long face with a wide jaw, big ears, heavy brows, a big nose and a broad smile."""
    outline = arc((256, 256), (104, 178), (-0.5, 0.5))
    outline[:, 0] = 256 + (outline[:, 0] - 256) * (1 + 0.16 * np.clip((outline[:, 1] - 240) / 150, 0, 1))
    lines = [outline]
    for side in (-1, 1):
        lines.append(arc((256 + side * 112, 250), (side * 30, 44), (-0.3, 0.3)))
        lines.append(arc((256 + side * 50, 196), (34, 18), (0.56, 0.94)))
        lines.append(arc((256 + side * 50, 236), (27, 13), (0.5, 1.0)))
        lines.append(arc((256 + side * 50, 236), (27, 9), (0.5, 0.0)))
    lines.append(arc((256, 316), (40, 22), (0.5, 0.0)))
    lines.append(arc((256, 362), (66, 14), (0.5, 0.0)))
    lines.append(arc((256, 362), (66, 36), (0.5, 0.0)))
    return lines


class Hand:
    """What a person does to the page. page: of Playwright. seconds: when every step was done. frames: of the film."""

    def __init__(self, page: Page, out: Path, speed: float, begun: float) -> None:
        self.page = page
        self.out = out
        self.speed = speed
        self.begun = begun
        self.seconds: dict[str, float] = {}
        self.frames: list[Image.Image] = []

    def done(self, step: str, picture: str | None = None) -> None:
        """A step is done; keep its time and what is seen, when the head has settled."""
        self.seconds[step] = round(time.perf_counter() - self.begun, 1)
        if picture is not None:
            self.page.wait_for_timeout(1800)
            self.page.screenshot(path=self.out / f"{picture}.jpg", type="jpeg", quality=88)

    def film(self) -> None:
        """A frame of the film."""
        picture = Image.open(io.BytesIO(self.page.screenshot(type="jpeg", quality=92)))
        self.frames.append(picture.resize((GIF[0], GIF[0] * SIZE[1] // SIZE[0]), Image.Resampling.LANCZOS))

    def stroke(self, places: np.ndarray, filmed: bool = False) -> None:
        """Draw over the screen at the hand's speed, and wait for the head."""
        ways = np.linalg.norm(np.diff(places, axis=0), axis=1)
        along = np.concatenate([[0], np.cumsum(ways)])
        steps = np.linspace(0, along[-1], max(2, int(along[-1] / STEP)))
        path = np.stack([np.interp(steps, along, places[:, axis]) for axis in (0, 1)], axis=1)
        shown = self.shown()
        self.page.mouse.move(*path[0])
        self.page.mouse.down()
        for number, place in enumerate(path[1:]):
            self.page.mouse.move(*place)
            time.sleep(STEP / self.speed)
            if filmed and number % 12 == 6:
                self.film()
        self.page.mouse.up()
        self.page.wait_for_function(f"{SHOWN} > {shown}", timeout=60_000)
        if filmed:
            self.film()
        time.sleep(REST)

    def shown(self) -> int:
        """Number of the head that is seen."""
        return self.page.evaluate(SHOWN)

    def press(self, words: str) -> None:
        """Press a button, and wait for the head."""
        shown = self.shown()
        self.page.get_by_role("button", name=words, exact=True).click()
        self.page.wait_for_function(f"{SHOWN} > {shown}", timeout=60_000)
        time.sleep(REST)

    def canvas(self, line: np.ndarray) -> np.ndarray:
        """Where a line of a canvas of 512 is on the screen."""
        box = self.page.locator(".caricli-canvas canvas:visible").bounding_box()
        assert box is not None
        return np.array([box["x"], box["y"]]) + line * box["width"] / 512


def play(hand: Hand) -> None:
    """From an empty canvas to a rig."""
    page = hand.page
    hand.film()
    for line in caricature():
        hand.stroke(hand.canvas(line), filmed=True)
    hand.done("drawn")
    hand.press("Follow my lines")
    hand.film()
    hand.done("followed", "studio-draw")
    page.get_by_role("tab", name="Face").click()
    page.get_by_role("button", name="More", exact=True).wait_for()
    hand.press("More")
    hand.film()
    hand.done("exaggerated", "studio-face")
    page.get_by_role("button", name="Save").click()
    with page.expect_download(timeout=120_000) as download:
        page.locator("[data-kind=rig]").click()
    download.value.save_as(hand.out / "rig.glb")
    page.keyboard.press("Escape")
    hand.done("GLB saved")
    page.get_by_role("tab", name="Refine").click()
    page.wait_for_timeout(600)
    page.get_by_role("button", name="Gesture", exact=True).click()
    page.wait_for_timeout(600)
    box = page.locator(".caricli-head canvas").bounding_box()
    assert box is not None
    nose = np.array([box["x"] + box["width"] / 2, box["y"] + 0.57 * box["height"]])
    hand.stroke(nose + arc((0, 0), (44, 44), (0, 1.02)))
    hand.press("Bulge 3")
    hand.film()
    hand.done("bulged", "studio-refine")
    page.get_by_role("tab", name="Redraw").click()
    hand.done("lines of the face", "studio-redraw")


def main() -> None:
    """Serve, play and keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--speed", type=float, default=250)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        begun = time.perf_counter()
        server = subprocess.Popen(
            [sys.executable, "-m", "caricli", "studio", "--no-browser", "--port", "0"],
            stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        assert server.stdout is not None
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, accept_downloads=True)
        page.goto(server.stdout.readline().strip())
        page.wait_for_function(f"{SHOWN} > 0", timeout=60_000)
        hand = Hand(page, options.out, options.speed, begun)
        hand.done("page is there")
        play(hand)
        browser.close()
        server.kill()
    (options.out / "seconds.json").write_text(json.dumps(hand.seconds, indent=1) + "\n")
    frames = [frame.quantize(64) for frame in hand.frames]
    frames[0].save(
        options.out / "studio.gif", save_all=True, append_images=frames[1:], duration=GIF[1], loop=0, optimize=True
    )


if __name__ == "__main__":
    main()
