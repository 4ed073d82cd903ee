"""Pictures that are drawn again, by path."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.image import read_alpha, read_image
from caricli.methods.redraw.original import Original
from caricli.store.face_pictures import FaceReader
from caricli.store.pictures import load_regions
from caricli.structures import Rig
from caricli.template.template import Template

_OPAQUE = 255


def load_original(
    rig: Rig, template: Template, path: Path, parsing: Path | None = None, reader: FaceReader | None = None
) -> Original:
    """The Original of a rig's picture.

    template: of the rig's skin. path: of the picture. parsing: of its label map, or None to let the detector of a
    FaceReader see what is before the head.
    Raises InputError when the rig has no camera, and where the picture shows no head where this sees one, or surely a
    face elsewhere.
    """
    landmarks = rig.require_depiction().landmarks
    picture = read_image(path)
    given = None if landmarks is None else (reader or FaceReader()).given(picture, landmarks)
    if given is not None and given.elsewhere:
        raise InputError(
            f"{shown(path)}: expected the picture that the face was fitted to, found a face in another place"
        )
    if parsing is None:
        regions = None if given is None else given.regions
    else:
        regions = load_regions(parsing, (picture.shape[1], picture.shape[0]), landmarks)
    with naming(path):
        return Original(rig, template, picture, regions, layer=_layer(path))


def _layer(path: Path) -> np.ndarray | None:
    """A picture with how opaque it is, (H, W, 4) uint8, or None where it is opaque everywhere."""
    alpha = read_alpha(path)
    if alpha is None or alpha.min() == _OPAQUE:
        return None
    return np.dstack([read_image(path, opaque=True), alpha])
