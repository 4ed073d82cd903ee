"""Latency and memory of the studio in Chromium: studio.py [--strokes N] [--operations N] -o studio.json.

From pen-up to the updated head on screen, and updates a second of a dragged handle, as the page's own clock has them;
memory of the server after a tenth of the operations and after all.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright

from caricli.methods.session.history import History
from caricli.store.session_tools import SessionTools, load_start
from caricli.structures import Operation

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
HEAD = ".caricli-head canvas"
CANVAS = ".caricli-canvas canvas"
WATCH = """() => {
  const head = document.querySelector(".caricli-head canvas");
  const canvas = document.querySelector(".caricli-canvas canvas");
  window.late = [];
  canvas.addEventListener("pointerup", () => { window.lifted = performance.now(); });
  new MutationObserver(() => {
    if (window.lifted) window.late.push(performance.now() - window.lifted);
    window.lifted = 0;
  }).observe(head, {attributeFilter: ["data-shown"]});
}"""


def ring(rng: np.random.Generator) -> np.ndarray:
    """(12, 2) pixels of a canvas of 512: an oval somewhere on it."""
    turn = np.linspace(0, rng.uniform(2, 6), 12)
    middle = rng.uniform(150, 360, 2)
    return middle + rng.uniform(10, 120, 2) * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def draw(page: Page, points: np.ndarray) -> None:
    """A stroke by the mouse, and a wait until its head is seen."""
    box = page.locator(CANVAS).bounding_box()
    before = page.evaluate("window.late.length")
    places = [(box["x"] + x * box["width"] / 512, box["y"] + y * box["height"] / 512) for x, y in points]
    page.mouse.move(*places[0])
    page.mouse.down()
    for place in places[1:]:
        page.mouse.move(*place)
    page.mouse.up()
    page.wait_for_function(f"window.late.length > {before}", timeout=60_000)


def drag(page: Page, seconds: float = 3.0) -> float:
    """Updates a second of the head, the usual one, while a point is dragged, from the first of them."""
    page.get_by_role("button", name="New").click()
    page.wait_for_timeout(2000)
    page.get_by_role("tab", name="Face").click()
    page.get_by_role("switch", name="Drag points on the head").click()
    page.wait_for_function(f"document.querySelector('{HEAD}').style.cursor == 'crosshair'")
    box = page.locator(HEAD).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.57 * box["height"]
    count = f"+(document.querySelector('{HEAD}').dataset.pulled || 0)"
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 1)
    page.wait_for_function(f"{count} > 0", timeout=60_000)
    first = page.evaluate(count)
    start = time.perf_counter()
    step = 0
    while time.perf_counter() - start < seconds:
        step += 1
        page.mouse.move(x, y + 10 * np.sin(step / 5))
    updates = page.evaluate(count) - first
    rate = updates / (time.perf_counter() - start)
    page.mouse.up()
    return rate


def measure_page(strokes: int) -> dict:
    """Latencies in milliseconds over strokes in a page of a server in a process of its own."""
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    words = [sys.executable, "-m", "caricli", "studio", "--no-browser", "--port", "0"]
    rng = np.random.default_rng(0)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        begun = time.perf_counter()
        server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment)
        assert server.stdout is not None
        url = server.stdout.readline().strip()
        served = time.perf_counter() - begun
        page.goto(url)
        page.wait_for_function(f"document.querySelector('{HEAD}')?.dataset.shown", timeout=60_000)
        usable = time.perf_counter() - begun - served
        page.evaluate(WATCH)
        for number in range(strokes + 1):
            if number and number % 12 == 0:
                page.get_by_role("button", name="Clear").click()
                page.wait_for_timeout(1000)
            draw(page, ring(rng))
        late = page.evaluate("window.late")[1:]
        rate = drag(page)
        browser.close()
    server.kill()
    middle, most = np.percentile(late, [50, 95])
    return {
        "strokes": len(late),
        "median_ms": float(middle),
        "percentile_95_ms": float(most),
        "drag_updates_per_second": rate,
        "seconds_to_serve": served,
        "seconds_from_served_to_usable": usable,
    }


def resident() -> float:
    """MiB of this process in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def measure_memory(operations: int) -> dict:
    """MiB of a process with one history after a tenth of the operations and after all of them."""
    tools = SessionTools()
    history = History(load_start(None, tools), tools)
    rng = np.random.default_rng(0)
    labels = tools.directions.names
    sizes = {}
    for number in range(1, operations + 1):
        if number % 4:
            history.do(Operation("semantic", {"strengths": {str(rng.choice(labels)): float(rng.normal(0, 0.3))}}))
        else:
            history.do(Operation("draw", {"points": ring(rng).tolist()}))
        if number in (operations // 10, operations):
            sizes[number] = resident()
    few, many = sizes.values()
    return {"operations": operations, "after_a_tenth_mib": few, "after_all_mib": many, "ratio": many / few}


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strokes", type=int, default=200)
    parser.add_argument("--operations", type=int, default=1000)
    parser.add_argument("-o", "--out", type=Path, required=True)
    options = parser.parse_args()
    report: dict[str, object] = {"memory": measure_memory(options.operations), "page": measure_page(options.strokes)}
    report |= {"cores": os.cpu_count(), "load": os.getloadavg()[0]}
    options.out.write_text(json.dumps(report, indent=2) + "\n")
    print(json.dumps(report, indent=2))


if __name__ == "__main__":
    main()
