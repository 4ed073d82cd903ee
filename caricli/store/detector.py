"""The detector that comes with caricli, and users' own."""

from pathlib import Path

from caricli.models.detector.model import Detector, detector_from_checkpoint
from caricli.store.bundled import load_bundled

BUNDLED = "detector.safetensors"


def load_detector(path: Path | None = None) -> Detector:
    """Load the detector of a file, or the bundled one.

    Raises InputError when it is no detector, damaged, or not there.
    """
    return load_bundled(BUNDLED, detector_from_checkpoint, path)
