"""The picture of a face in its chart, retouched by hand, back on the head."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid, chart_to_texture, texture_to_chart
from caricli.structures import Face
from caricli.structures.chart import FaceChart

_TOUCHED = 2
"""Levels of 255 up to which a texel is as it was."""

_OTHER = 0.5
"""Correlation below which a picture is hardly one of the face."""


@dataclass(frozen=True, eq=False)
class Retouched:
    """A head's texture, retouched.

    texture: (H, H, 3) uint8. touched: share of the face that changed. alike: correlation of the picture with what the
    face wears.
    """

    texture: np.ndarray
    touched: float
    alike: float

    def doubt(self) -> str | None:
        """What speaks against the picture, for a message, or None."""
        return "hardly looks like what the face wears: is it of another chart?" if self.alike < _OTHER else None


def retouch_texture(face: Face, picture: np.ndarray, chart: FaceChart) -> Retouched:
    """The texture of a head with what was changed in the picture of its face.

    Only differences are carried, so that what nobody touched keeps its texels. What is between the lips has no place on
    the head, and is left aside.

    face: Face with a texture. picture: (S, S, 3) uint8, as `texture --uv arap` wrote it, changed, of any size. chart:
    FaceChart of the face. Raises InputError for a face without a texture, and for a picture that is not square.
    """
    texture = face.pictures.skin
    if texture is None:
        raise InputError("expected a face with a picture on its skin, as `caricli texture` writes one, found none")
    height, width = picture.shape[:2]
    if height != width:
        raise InputError(f"expected a square picture in the chart, as texture-arap.png is, found {width} x {height}")
    if len(texture) != texture.shape[1]:
        raise InputError(f"expected a face with a square texture, found {texture.shape[1]} x {len(texture)}")
    grid = ChartGrid(chart, height)
    written = texture_to_chart(texture, face.mesh, ChartGrid(chart, len(texture)))
    # As programs resize what they are given; another sampling of the texture would count as touched.
    way = cv2.INTER_AREA if height < len(texture) else cv2.INTER_CUBIC
    own = cv2.resize(written, (width, height), interpolation=way)
    skin = grid.covered & ~grid.mouth
    change = np.where(skin[..., None], picture.astype(np.float32) - own, 0)
    back = chart_to_texture(change, face.mesh, grid, len(texture))
    painted = np.rint(np.clip(texture + back, 0, 255)).astype(np.uint8)
    touched = (np.abs(change[skin]) > _TOUCHED).any(1).mean()
    with np.errstate(invalid="ignore"):
        alike = np.corrcoef(picture[skin].ravel(), own[skin].ravel())[0, 1]
    # A plain picture agrees with nothing.
    return Retouched(painted, float(touched), float(np.nan_to_num(alike)))
