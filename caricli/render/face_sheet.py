"""Faces from several sides, one beside the other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.shade import Look
from caricli.render.views import render_views, turntable
from caricli.structures import Mesh
from caricli.template.annotation import bundled_annotation


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


def face_sheet(meshes: Sequence[Mesh], names: Sequence[str], settings: SheetSettings) -> np.ndarray:
    """Pictures of faces with their names, or of one face; heads of the bundled topology get eyeballs.

    Returns (H, W, 3) uint8.
    """
    strips = [_strip(mesh, settings) for mesh in meshes]
    if len(strips) == 1:
        return contact_sheet(strips[0], settings.columns or (None if settings.frames else len(settings.views)))
    return contact_sheet([np.hstack(strip) for strip in strips], settings.columns, list(names))


def _strip(mesh: Mesh, settings: SheetSettings) -> list[np.ndarray]:
    look = Look(eyeballs=place_eyeballs(mesh, bundled_annotation()))
    if settings.frames:
        return turntable(mesh, settings.frames, settings.size, look)
    return render_views(mesh, settings.views, settings.size, look)
