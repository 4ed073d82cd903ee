"""Datasets of folders."""

from pathlib import Path


def dataset_files(folder: Path) -> list[Path]:
    """The files of a dataset folder, which no output may replace."""
    return [folder / "dataset.json", *folder.glob("*.npz")]
