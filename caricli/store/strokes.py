"""The stroke network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.strokes.model import StrokeModel, strokes_from_checkpoint

BUNDLED = "strokes.safetensors"


def load_strokes(path: Path | None = None) -> StrokeModel:
    """Load the stroke network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    file = asset_path(BUNDLED) if path is None else path
    return strokes_from_checkpoint(*read_checkpoint(file), shown(file))
