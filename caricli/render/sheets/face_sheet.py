"""Faces from several sides, one beside the other."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from caricli.render.backdrop import on_backdrop, row_of
from caricli.render.face_look import face_look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.views import render_views, turntable
from caricli.structures import Face


@dataclass(frozen=True)
class SheetSettings:
    """What is drawn of a face.

    views: keys of VIEWS.
    frames: instead of the views, pictures of one turn; None for the views.
    size: pixels, side of one picture.
    columns: pictures in a row: faces, or with one face its views; None for near to a square, and all views in a row.
    eyeballs: whether heads of the bundled topology get eyes where they have none.
    """

    views: tuple[str, ...] = ("front", "three-quarter", "profile")
    frames: int | None = None
    size: int = 512
    columns: int | None = None
    eyeballs: bool = True

    @property
    def count(self) -> int:
        """Pictures of one face."""
        return self.frames or len(self.views)


def face_sheet(faces: Sequence[Face], names: Sequence[str], settings: SheetSettings) -> np.ndarray:
    """Pictures of faces in what they wear, with their names, or of one face.

    Heads of the bundled topology get eyeballs unless they have eyes of their own. Returns (H, W, 3) uint8.
    """
    strips = [_strip(face, settings) for face in faces]
    if len(strips) == 1:
        return contact_sheet(strips[0], settings.columns or (None if settings.frames else len(settings.views)))
    return contact_sheet([row_of(strip) for strip in strips], settings.columns, list(names))


def turning_faces(
    faces: Sequence[Face], names: Sequence[str], settings: SheetSettings, progress: Callable[[int, int], object]
) -> Iterator[np.ndarray]:
    """The frames of a film in which a face turns once, or several do beside each other with their names.

    settings: of a turn. progress: called with finished frames and their total. Yields (H, W, 3) uint8.
    """
    turns = zip(
        *(turntable(face.mesh, settings.count, settings.size, face_look(face, settings.eyeballs)) for face in faces),
        strict=True,
    )
    for k, pictures in enumerate(turns):
        alone = len(pictures) == 1
        yield on_backdrop(pictures[0]) if alone else contact_sheet(pictures, settings.columns, list(names))
        progress(k + 1, settings.count)


def _strip(face: Face, settings: SheetSettings) -> list[np.ndarray]:
    look = face_look(face, settings.eyeballs)
    if settings.frames:
        return [*turntable(face.mesh, settings.frames, settings.size, look)]
    return render_views(face.mesh, settings.views, settings.size, look)
