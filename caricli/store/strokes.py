"""The stroke network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.models.strokes.model import StrokeModel, strokes_from_checkpoint
from caricli.store.bundled import load_bundled

BUNDLED = "strokes.safetensors"


def load_strokes(path: Path | None = None) -> StrokeModel:
    """Load the stroke network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, strokes_from_checkpoint, path)
