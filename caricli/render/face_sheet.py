"""Faces from several sides, one beside the other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.render.backdrop import row_of
from caricli.render.contact_sheet import contact_sheet
from caricli.render.face_look import face_look
from caricli.render.views import render_views, turntable
from caricli.structures import Face


@dataclass(frozen=True)
class SheetSettings:
    """What is drawn of a face.

    views: keys of VIEWS.
    frames: instead of the views, pictures of one turn; None for none.
    size: pixels, side of one picture.
    columns: pictures in a row: faces, or with one face its views; None for near to a square, and all views in a row.
    """

    views: tuple[str, ...] = ("front", "three-quarter", "profile")
    frames: int | None = None
    size: int = 512
    columns: int | None = None

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


def _strip(face: Face, settings: SheetSettings) -> list[np.ndarray]:
    look = face_look(face)
    if settings.frames:
        return turntable(face.mesh, settings.frames, settings.size, look)
    return render_views(face.mesh, settings.views, settings.size, look)
