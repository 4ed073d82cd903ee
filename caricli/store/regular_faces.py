"""Faces that are to be made caricatures: of face files, or of landmarks with their pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.errors import shown
from caricli.methods.faces.encode_face import EncodedFace
from caricli.models.shape_model import ShapeModel
from caricli.render.sheets.crop_portrait import crop_portrait
from caricli.store.faces import load_latent_face
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.pictures import load_found_marks


@dataclass(frozen=True, eq=False)
class RegularFace:
    """A face, and what is to be said and shown of where it comes from.

    face: EncodedFace.
    note: a line that says that it was encoded or reconstructed, or None.
    portrait: (H, H, 3) uint8, the face in its picture, or None.
    """

    face: EncodedFace
    note: str | None
    portrait: np.ndarray | None = None


FaceLoader = Callable[[Path, Path | None], RegularFace]
"""Called with the path of a face or of landmarks, and with that of the picture or None."""


def face_loader(model: ShapeModel, anew: bool) -> FaceLoader:
    """Load face files; model, anew: as in ``load_latent_face``."""
    return lambda path, _: RegularFace(*load_latent_face(path, model, anew))


def landmark_loader(model: ShapeModel, pts_origin: int, size: int) -> FaceLoader:
    """Reconstruct the faces of landmark files; those that were found are followed as surely as they are known.

    model: ShapeModel of the latents. pts_origin: coordinate of the first pixel in .pts files. size: pixels, side of a
    portrait.
    """
    encoder = elastic_encoder(model)
    count = len(model.template.annotation.landmarks)

    def load(path: Path, image: Path | None) -> RegularFace:
        marks, picture = load_found_marks(path, count, image, pts_origin)
        face, nme = encoder.encode(marks.head_points, marks.spreads)
        portrait = None if picture is None else crop_portrait(picture, marks.points, size)
        return RegularFace(face, f"{shown(path)}: reconstructed, NME {nme:.2f} %", portrait)

    return load
