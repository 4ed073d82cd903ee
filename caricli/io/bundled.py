"""Where the files that come with caricli are."""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def asset_path(name: str) -> Path:
    """Return the path of the bundled asset `name`, such as "head_annotation.json"."""
    return PACKAGE / "assets" / name


def config_path(name: str) -> Path:
    """Return the path of the bundled configuration `name`, such as "pca/default.yaml"."""
    packed = PACKAGE / "configs"  # the wheel carries a copy; a checkout keeps them beside the package
    return (packed if packed.is_dir() else PACKAGE.parent / "configs") / name
