"""A hand on the head."""

import numpy as np

from caricli.studio.modes.refine_mode import TOOLS


def place(tab, vertex):
    """Pixels of the window where a vertex is."""
    test = """vertex => {
      const head = document.querySelector('.caricli-head').caricli;
      const { scale, rotation, translation } = head.seen();
      const box = head.canvas.getBoundingClientRect();
      const at = Array.from(head.positions.slice(3 * vertex, 3 * vertex + 3));
      const along = row => scale * rotation[row].reduce((sum, each, k) => sum + each * at[k], 0) + translation[row];
      return [box.left + along(0), box.top + along(1)];
    }"""
    return np.array(tab.page.evaluate(test, int(vertex)))


def use(tab, words):
    """Take a tool, until the head has it; entering the mode has given it another."""
    tool = next(name for name, label in TOOLS.items() if label == words)
    tab.page.get_by_role("button", name=words, exact=True).click()
    tab.page.wait_for_function("tool => document.querySelector('.caricli-head').caricli.tool == tool", arg=tool)


def stroke(tab, points):
    tab.page.mouse.move(*points[0])
    tab.page.mouse.down()
    for point in points[1:]:
        tab.page.mouse.move(*point)
    tab.page.mouse.up()


def roll(start, loops, side):
    """A line to the right with loops above it (side -1) or below."""
    turns = np.linspace(0, 2 * np.pi * loops, 30 * loops)
    curve = np.stack([16 * np.sin(turns) + 28 * turns / (2 * np.pi), side * 20 * (1 - np.cos(turns))], 1)
    before = [[x, 0] for x in np.linspace(-50, 0, 12)]
    after = curve[-1] + [[x, 0] for x in np.linspace(0, 50, 12)]
    return start + np.concatenate([before, curve, after])
