"""The gesture network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.gesture.model import GestureModel, gesture_from_checkpoint

BUNDLED = "gesture.safetensors"


def load_gestures(path: Path | None = None) -> GestureModel:
    """Load the gesture network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    file = asset_path(BUNDLED) if path is None else path
    return gesture_from_checkpoint(*read_checkpoint(file), shown(file))
