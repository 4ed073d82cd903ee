"""Views of several heads on one sheet."""

from collections.abc import Sequence

import numpy as np

from caricli.render.backdrop import on_backdrop, row_of
from caricli.render.sheets.contact_sheet import contact_sheet


def film_strip(heads: Sequence[Sequence[np.ndarray]], labels: Sequence[str]) -> np.ndarray:
    """Heads beside each other, the views of each in a column.

    heads: of each its views, (H, W, 3 or 4) uint8. labels: one text a head.
    Returns (H, W, 3) uint8.
    """
    return contact_sheet([np.vstack([on_backdrop(view) for view in views]) for views in heads], len(heads), labels)


def view_rows(heads: Sequence[Sequence[np.ndarray]], labels: Sequence[str]) -> np.ndarray:
    """Heads below each other, the views of each in a row; arguments and result as in ``film_strip``."""
    return contact_sheet([row_of(views) for views in heads], 1, labels)
