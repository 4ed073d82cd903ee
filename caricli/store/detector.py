"""The detector that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.detector.model import Detector, detector_from_checkpoint

BUNDLED = "detector.safetensors"


def has_detector() -> bool:
    """Whether a detector comes with this version."""
    return asset_path(BUNDLED).is_file()


def load_detector(path: Path | None = None) -> Detector:
    """Load the detector of a file, or the bundled one.

    Raises InputError when it is no detector, damaged, or not there.
    """
    file = asset_path(BUNDLED) if path is None else path
    if path is None and not has_detector():
        raise InputError(
            "no trained detector comes with this version: `caricli dataset pictures` and `caricli train detector` make "
            "one, and --detector RUN/model.safetensors takes it"
        )
    return detector_from_checkpoint(*read_checkpoint(file), shown(file))
