"""The picture that rigs are written with."""

from pathlib import Path

import numpy as np

from caricli.commands.shared.progress import progress_bar
from caricli.io.image import write_png
from caricli.structures import Rig


def write_expression_sheet(path: Path, rig: Rig, given: np.ndarray | None = None) -> None:
    """Draw every expression of a rig, with progress. given: (V, 3) metres, another shape to begin with, or None."""
    # Rasterising is slow to import, and failures come first.
    from caricli.render.sheets.expression_sheet import expression_sheet

    with progress_bar("drawing") as progress:
        write_png(path, expression_sheet(rig, progress, given))
