"""What every mode of the page is."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from caricli.studio.page import Page


class Mode:
    """One tab of the page.

    name: of the tab, also in addresses. label: what the tab says.
    """

    name = ""
    label = ""

    def __init__(self, page: "Page") -> None:
        """page: Page that it is part of."""
        self.page = page

    @property
    def shown(self) -> bool:
        """Whether its tab is the open one."""
        return self.page.tabs.value == self.name

    def build(self) -> None:
        """Lay out its panel, at the left of the head."""

    def listen(self) -> None:
        """Listen to the head, which is there by now."""

    def begin(self) -> None:
        """Something else was opened."""

    def refresh(self, answered: int = 0) -> None:
        """Show the present work, in a mode whose tab is open. answered: strokes of the canvas that it comes from."""
