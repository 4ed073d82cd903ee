"""Datasets of folders."""

from pathlib import Path


def dataset_files(folder: Path) -> list[Path]:
    """The files of a dataset folder, which no output may replace."""
    return [*folder.glob("*.json"), *folder.glob("*.npz")]


def is_picture_set(folder: Path) -> bool:
    """Whether a folder is one of pictures; what it is else is for its reader to say."""
    from caricli.data.picture_set import MANIFEST

    return (folder / MANIFEST).exists()


def is_texture_set(folder: Path) -> bool:
    """Whether a folder is one of textures with expressions."""
    from caricli.data.texture_set import MANIFEST

    return (folder / MANIFEST).exists()
