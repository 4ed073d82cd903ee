"""axe-core finds nothing serious on any page, light and dark."""

from importlib.resources import files

import pytest

AXE = """async () => {
  const seen = await axe.run(document, {resultTypes: ["violations"]});
  return seen.violations.filter(each => ["serious", "critical"].includes(each.impact))
    .map(each => `${each.id}: ${each.nodes.map(node => node.html.slice(0, 160)).join(" | ")}`);
}"""

STILL = """() => document.getAnimations().every(each => each.effect.getComputedTiming().iterations === Infinity)"""
"""Nothing fades any more: what does is pale for a moment."""


@pytest.mark.parametrize("dark", [False, True])
def test_nothing_serious_stands_in_the_way(tab, dark):
    script = files("axe_core_python") / "axe.min.js"
    if dark:
        tab.page.get_by_role("button", name="Light or dark").click()
        tab.page.locator("body.body--dark").wait_for()
    tabs = tab.page.get_by_role("tab")
    for number in range(tabs.count()):
        before = tab.page.locator(".caricli-panel").element_handle()
        tabs.nth(number).click()
        if number:
            before.wait_for_element_state("hidden")
        tab.page.wait_for_timeout(700)
        tab.page.wait_for_function(STILL)
        tab.page.add_script_tag(content=script.read_text("utf-8"))
        assert tab.page.evaluate(AXE) == [], number


def test_everything_is_reached_by_keys(tab):
    tab.page.keyboard.press("Tab")
    reached = set()
    for _ in range(40):
        reached.add(tab.page.evaluate("document.activeElement.innerText || document.activeElement.ariaLabel || ''"))
        tab.page.keyboard.press("Tab")
    words = " ".join(reached).lower()
    assert all(name in words for name in ("open", "save", "clear", "follow my lines", "front", "the head in three"))
