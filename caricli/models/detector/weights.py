"""What the detector's network has learnt, and what its values are called."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from caricli.models.detector.config import DetectorSize

WINDOWS = "windows"
FACES = "faces"
FEATURES = "features"
CHANCES = "chances"


@dataclass(frozen=True, eq=False)
class DetectorWeights:
    """What the network has learnt.

    arrays: by the names that they have in ``networks.DetectorNetwork``. size: DetectorSize of it.
    """

    arrays: Mapping[str, np.ndarray]
    size: DetectorSize

    @property
    def count(self) -> int:
        """How many numbers that is."""
        return sum(array.size for name, array in self.arrays.items() if "running" not in name)
