"""The gesture network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.models.gesture.model import GestureModel, gesture_from_checkpoint
from caricli.store.bundled import load_bundled

BUNDLED = "gesture.safetensors"


def load_gestures(path: Path | None = None) -> GestureModel:
    """Load the gesture network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, gesture_from_checkpoint, path)
