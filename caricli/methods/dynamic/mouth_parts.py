"""What lies behind open lips: teeth, gums and tongue of the head's own geometry, seen from before the face."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.parts.attachment import attachment_for
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Material, Part
from caricli.structures.arkit import alone
from caricli.structures.materials import IN_MOUTH
from caricli.template.template import Template

_PIXEL = 0.005  # of the face's width
_LONGEST = 256  # pixels, of what is looked at
_MARGIN = 2  # pixels
_BLUR = 3  # pixels, which a texel of the chart is wide about


@dataclass(frozen=True, eq=False)
class MouthParts:
    """What a mouth of W vertices and F triangles has inside.

    vertices: (W, 3) metres, of the neutral face. deltas: (K, W, 3) metres, what K expressions do to it. faces: (F, 3).
    teeth: (F,) bool, where triangles are teeth and neither gums nor tongue.
    """

    vertices: np.ndarray
    deltas: np.ndarray
    faces: np.ndarray
    teeth: np.ndarray

    @classmethod
    def of(cls, parts: Sequence[Part]) -> "MouthParts | None":
        """Those of a head's parts that are inside the mouth, or None."""
        inside = [part for part in parts if np.isin(part.materials, IN_MOUTH).all()]
        if not inside:
            return None
        starts = np.cumsum([0, *(len(part.mesh.vertices) for part in inside)])
        kinds = [np.repeat(part.materials, part.mesh.triangles_of_polygons) for part in inside]
        return cls(
            np.concatenate([part.mesh.vertices for part in inside]),
            np.concatenate([part.deltas for part in inside], axis=1),
            np.concatenate([part.mesh.faces + start for part, start in zip(inside, starts, strict=False)]),
            np.concatenate(kinds) == Material.TEETH,
        )

    @classmethod
    def in_face(cls, template: Template, deltas: np.ndarray) -> "MouthParts | None":
        """Of a face, as its topology has them; None where it has none.

        template: Template with the neutral face's vertices. deltas: (K, V, 3) metres, what expressions do to the skin.
        """
        attachment = attachment_for(template)
        if attachment is None:
            return None
        names = [str(k) for k in range(len(deltas))]
        return cls.of(attachment.without_lashes().animate(template, alone(names), deltas))

    def moved(self, weights: np.ndarray) -> np.ndarray:
        """(W, 3) metres, its vertices with weights (K,) of the expressions."""
        return self.vertices + np.tensordot(weights, self.deltas, 1)


def look_inside(parts: MouthParts, vertices: np.ndarray, between: np.ndarray) -> np.ndarray:
    """What is seen of a mouth through places between the lips.

    vertices: (W, 3) of the parts and between: (M, 3), in widths of the face, right, up and towards the viewer.
    Returns (M, 3) float32: how much is teeth, how much gums and tongue, each from 0 to 1, and how far behind the place
    they are.
    """
    if not len(between):
        return np.zeros((0, 3), np.float32)
    corner = np.array([between[:, 0].min(), between[:, 1].max(), 0])
    sizes = np.ptp(between[:, :2], axis=0)
    step = max(_PIXEL, float(sizes.max()) / _LONGEST)
    pixels = (vertices - corner) / step * [1, -1, -1] + [_MARGIN, _MARGIN, 0]
    width, height = (np.ceil(sizes / step).astype(int) + 2 * _MARGIN + 1).tolist()
    raster = rasterise(pixels, parts.faces, width, height)
    hit = raster.face >= 0
    teeth = hit & parts.teeth[raster.face]
    deep = np.where(hit, raster.depth, raster.depth[hit].max(initial=0)) * step
    picture = cv2.blur(np.dstack([teeth, hit & ~teeth, deep]).astype(np.float32), (_BLUR, _BLUR))
    columns, rows = ((between[:, :2] - corner[:2]) / step * [1, -1] + _MARGIN).astype(np.float32).T
    seen = cv2.remap(picture, columns[None], rows[None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
    seen[:, 2] += between[:, 2]
    return seen
