"""The texture network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.models.texture.model import TextureModel, texture_from_checkpoint

BUNDLED = "texture.safetensors"


def has_texture_network() -> bool:
    """Whether a texture network comes with this version."""
    return asset_path(BUNDLED).is_file()


def load_texture_network(path: Path | None = None) -> TextureModel:
    """Load the texture network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    file = asset_path(BUNDLED) if path is None else path
    if path is None and not has_texture_network():
        raise InputError(
            "no trained texture network comes with this version: `caricli dataset textures` and `caricli train "
            "texture` make one"
        )
    return texture_from_checkpoint(*read_checkpoint(file), shown(file))
