"""Maps between landmarks of normal faces and caricatures, by path or the bundled one."""

from pathlib import Path

from caricli.errors import shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.landmark_map.model import LandmarkMap, map_from_checkpoint


def landmark_map_path(path: Path | None = None) -> Path:
    """The file of a map that was given, or the bundled one."""
    return asset_path("landmark_map.safetensors") if path is None else path


def load_landmark_map(path: Path | None = None) -> LandmarkMap:
    """Load the map of a file, or the bundled one. Raises InputError when it is none."""
    path = landmark_map_path(path)
    return map_from_checkpoint(*read_checkpoint(path), shown(path))
