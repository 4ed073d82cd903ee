"""A server of one's own in another process, and Chromium."""

import asyncio
import os
import shutil
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
HEAD = "document.querySelector('.caricli-head').caricli.coordinates()"
PATIENCE = 300_000
"""Milliseconds that a busy machine may need for one step."""


def run_apart(work: Coroutine[Any, Any, None]) -> None:
    """Run what waits in a thread of its own: in this one the browser's loop may be running."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, work).result()


class Server:
    """`caricli studio` as a user starts it. url: of the page."""

    def __init__(self, folder: Path, *words: str, port: int = 0) -> None:
        command = [sys.executable, "-m", "caricli", "studio", "--no-browser", "--port", str(port), *words]
        environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()
        if not self.url.startswith("http"):
            self.kill()
            pytest.fail(self.url + self.process.stdout.read())

    @property
    def port(self) -> int:
        """Where it serves."""
        return int(self.url.split(":")[2].split("/")[0])

    def kill(self) -> None:
        """As a crash does."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> int:
        """As Ctrl+C does; returns the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)


@pytest.fixture(scope="session")
def browser():
    """Chromium, or a loud word that there is none."""
    if CHROMIUM is None:
        warnings.warn("no Chromium is installed: the studio is not tested in a browser", stacklevel=1)
        pytest.skip("no Chromium is installed: the studio is not tested in a browser")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def server(browser, tmp_path_factory):
    """A server with an empty canvas."""
    own = Server(tmp_path_factory.mktemp("studio"))
    yield own
    own.kill()


@pytest.fixture
def tab(browser, server):
    """A new tab of the server, in a browser without a past."""
    context = browser.new_context(viewport={"width": 1280, "height": 720}, accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    page = Tab(context.new_page())
    page.go(server.url)
    yield page
    context.close()


class Tab:
    """The page as a person uses it. page: of Playwright. asked: addresses that it asked for. faults: what it threw."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.asked: list[str] = []
        self.faults: list[str] = []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("pageerror", lambda error: self.faults.append(str(error)))

    def go(self, url: str) -> None:
        """Load the page until the head is seen."""
        self.page.goto(url)
        self.wait(0)

    @property
    def shown(self) -> int:
        """Number of the frame that is seen."""
        return self.page.evaluate("+(document.querySelector('.caricli-head canvas').dataset.shown || 0)")

    def wait(self, after: int) -> None:
        """Wait for a frame later than one."""
        test = f"+(document.querySelector('.caricli-head canvas')?.dataset.shown || 0) > {after}"
        self.page.wait_for_function(test, timeout=PATIENCE)

    def lines(self, count: int) -> None:
        """Wait until the canvas has as many lines."""
        seen = "[...document.querySelectorAll('.caricli-canvas canvas')].find(each => each.offsetParent)"
        test = f"{seen}?.dataset.lines == '{count}'"
        self.page.wait_for_function(test, timeout=PATIENCE)

    def changed(self, act: Callable) -> None:
        """Do something and wait until the head shows what came of it."""
        before = self.shown
        act()
        self.wait(before)

    def head(self) -> list[float]:
        """Coordinates of all vertices, as the page has them."""
        return self.page.evaluate(HEAD)

    def becomes(self, coordinates: list[float]) -> None:
        """Wait until the head is another one."""
        test = f"head => JSON.stringify({HEAD}) == JSON.stringify(head)"
        self.page.wait_for_function(test, arg=coordinates, timeout=PATIENCE)

    def move(self, points: Any) -> None:
        """A line on the canvas by the mouse, without waiting. points: pixels of 512."""
        box = self.page.locator(".caricli-canvas canvas:visible").bounding_box()
        places = [(box["x"] + x * box["width"] / 512, box["y"] + y * box["height"] / 512) for x, y in points]
        self.page.mouse.move(*places[0])
        self.page.mouse.down()
        for place in places[1:]:
            self.page.mouse.move(*place)
        self.page.mouse.up()

    def draw(self, points: Any) -> None:
        """A line, until its face is seen."""
        self.changed(lambda: self.move(points))

    def press(self, words: str) -> None:
        """Press a button and wait for the head."""
        self.changed(lambda: self.page.get_by_role("button", name=words, exact=True).click())

    def mode(self, words: str) -> None:
        """Go to a mode."""
        self.page.get_by_role("tab", name=words, exact=True).click()

    def save(self, kind: str, path: Path) -> None:
        """Save by the menu."""
        self.page.get_by_role("button", name="Save").click()
        with self.page.expect_download(timeout=PATIENCE) as download:
            self.page.locator(f"[data-kind={kind}]").click()
        download.value.save_as(path)
        self.page.locator("[role=menu]").wait_for(state="hidden")  # when it goes, the keys go back to its button

    def open(self, path: Path) -> None:
        """Open a file."""
        self.page.locator(".caricli-keep input[type=file]").set_input_files(path)

    def told(self, words: str) -> None:
        """Wait until the page says something."""
        self.page.locator(".caricli-told", has_text=words).wait_for(timeout=PATIENCE)
