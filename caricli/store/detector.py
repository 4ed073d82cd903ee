"""The detector that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.detector.model import Detector, detector_from_checkpoint

BUNDLED = "detector.safetensors"


def load_detector(path: Path | None = None) -> Detector:
    """Load the detector of a file, or the bundled one.

    Raises InputError when it is no detector, damaged, or not there.
    """
    file = asset_path(BUNDLED) if path is None else path
    return detector_from_checkpoint(*read_checkpoint(file), shown(file))
