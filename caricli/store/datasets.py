"""Datasets of folders."""


def dataset_files(folder):
    """The files of a dataset folder, which no output may replace."""
    return [folder / "dataset.json", *folder.glob("*.npz")]
