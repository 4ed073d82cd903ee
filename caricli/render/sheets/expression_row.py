"""A face and some of its expressions, in a row."""

from collections.abc import Iterable

import numpy as np

from caricli.render.rig_stage import RigStage
from caricli.structures import Rig


def expression_row(rig: Rig, given: np.ndarray, names: Iterable[str], size: int) -> list[np.ndarray]:
    """Pictures from the front of a shape of a rig's vertices, and of expressions by name.

    given: (V, 3) metres. names: of expressions; the neutral face stands for those that the rig does not have. size:
    pixels.
    """
    shapes = [given, *(rig.shape(name) if name in rig.names else rig.neutral for name in names)]
    return [*RigStage(rig, "front", size).pictures(shapes)]
