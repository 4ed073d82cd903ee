"""What reconstructions of portraits are measured with: real pictures with landmarks, and the bundled models."""

from pathlib import Path
from typing import Any

from caricli.errors import InputError, shown
from caricli.methods.evaluate.portrait_studio import Portrait
from caricli.methods.evaluate.reconstruct_portrait import COARSE, NETWORK
from caricli.store.coarse import load_coarse_pair
from caricli.store.models import check_topology, load_model
from caricli.store.pictures import MARKS, load_marked_picture, marks_beside, pictures_in
from caricli.template.template import Template


def portrait_files(folder: Path | None) -> list[tuple[Path, Path]]:
    """Pictures of a folder with their landmark files; none where there is no folder."""
    if folder is None:
        return []
    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder of pictures, found none")
    pictures = pictures_in(folder)
    if not pictures:
        raise InputError(f"{shown(folder)}: expected pictures, found none")
    return [(path, _marks(path)) for path in pictures]


def _marks(picture: Path) -> Path:
    """The landmark file beside a picture. Raises InputError where there is none."""
    # One that is damaged says what is wrong with it when it is read.
    files = filter(Path.is_file, map(picture.with_suffix, MARKS))
    marks = marks_beside(picture) or next(files, None)
    if marks is None:
        raise InputError(f"{shown(picture)}: expected landmarks beside it, with one of {', '.join(MARKS)}; found none")
    return marks


def load_portrait(picture: Path, marks: Path, pts_origin: int = 1) -> Portrait:
    """A real portrait. pts_origin: coordinate of the first pixel in .pts files. Raises InputError."""
    landmarks, image = load_marked_picture(marks, picture, pts_origin)
    assert image is not None
    return Portrait(picture.name, image, landmarks.head_points)


def load_rivals(template: Template) -> dict[str, Any]:
    """What reconstructs portraits: the bundled models by kind, prepared, and the bundled network by NETWORK.

    Raises InputError when they are not of the template's topology.
    """
    models: dict[str, Any] = {kind: load_model(kind=kind) for kind in COARSE.values()}
    for kind, model in models.items():
        check_topology(model.template, template, f"the bundled {kind} model")
        model.prepare()
    return models | {NETWORK: load_coarse_pair()[0]}
