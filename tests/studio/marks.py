"""A hand on the landmarks of a picture."""

import numpy as np
import pytest

from tests.studio.conftest import PATIENCE

CANVAS = "document.querySelector('.marks')?.landmarks"


class Marks:
    """The mode as a person uses it. tab: Tab."""

    def __init__(self, tab):
        self.tab = tab
        self.page = tab.page

    def begin(self):
        """Go to the mode and wait for landmarks and the face that follows them."""
        self.tab.mode("Landmarks")
        self.until(f"{CANVAS}?.curves.length > 10 && {CANVAS}?.points.filter(Boolean).length > 8")

    def until(self, test):
        self.page.wait_for_function(test, timeout=PATIENCE)

    def points(self):
        """(L, 2), NaN where a point is off."""
        rows = self.page.evaluate(f"{CANVAS}.points")
        return np.array([row or [np.nan, np.nan] for row in rows], float)

    def where(self, number):
        """The screen's place of a point."""
        box = self.page.locator(".marks-dot").nth(number).locator(".marks-edge").bounding_box()
        return np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])

    def drag(self, number, by):
        """Drag a point by pixels of the screen and wait until it is done for good."""
        done = self.done()
        start = self.hold(number)
        for share in np.linspace(0.1, 1, 8):
            self.page.mouse.move(*(start + share * np.array(by)))
        assert self.page.locator(".marks-loupe").is_visible()
        self.page.mouse.up()
        self.answered(done)

    def hold(self, number):
        """Press on a point, until it is held: the page may still be finding its size. Returns the screen's place."""
        for _ in range(100):
            place = self.where(number)
            self.page.mouse.move(*place)
            self.page.mouse.down()
            if self.page.evaluate(f"{CANVAS}.hold?.number") == number:
                return place
            self.page.mouse.up()
        pytest.fail(f"point {number} cannot be held")

    def done(self):
        """How many answers came that are no tries."""
        return self.page.evaluate(f"{CANVAS}.answers")

    def answered(self, before):
        """Wait for such an answer."""
        self.until(f"{CANVAS}.answers > {before}")

    def press(self, key):
        """Press a key and wait until what it did is done for good."""
        done = self.done()
        self.page.keyboard.press(key)
        self.answered(done)

    def click(self, words):
        """Click a button of the mode."""
        self.page.get_by_role("button", name=words, exact=True).click()
