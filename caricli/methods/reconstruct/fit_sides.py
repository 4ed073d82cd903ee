"""Sides of a head that stand before what its picture shows behind it."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from caricli.geometry.cholesky import Cholesky
from caricli.methods.reconstruct.bending import bending
from caricli.methods.reconstruct.smaller_labels import smaller_labels
from caricli.render.pixels.widen_mask import widen_mask
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.structures import Camera, Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.parsing import Region
from caricli.template.annotation import EARS
from caricli.template.template import Template

_SKULL = ("scalp", "forehead")
"""Regions that may be under hair, which says where they are above the ears (``sink_skull``)."""

_NO_HEAD = (Region.BACKGROUND, Region.CLOTH, Region.OTHER)
"""What no head ends with."""

_LOOSE = 1e-6
"""How much any vertex stays, so that parts which nothing holds do."""


@dataclass(frozen=True)
class SideSettings:
    """How sides come in.

    Lengths are shares of the head's height. height: pixels of the head, to which larger pictures are made smaller.
    stiffness: of the surface against bending, in that of one point that pulls. rounds: of pulling, at most. near: to
    the outline, where vertices follow it. slight, far: from where the head ends, between which they do; least: of one
    of them, or none does. skull, rim: how much a vertex of the skull stays, and one of the outline that stands where it
    should; landmarks and ears count as much as what pulls.
    """

    height: int = 400
    stiffness: float = 20.0
    rounds: int = 6
    near: float = 0.02
    slight: float = 0.004
    least: float = 0.02
    far: float = 0.12
    skull: float = 0.02
    rim: float = 0.3


_SETTINGS = SideSettings()


def fit_sides(face: Face, template: Template, picture: ParsedPicture, anchors: np.ndarray) -> Face:
    """A face that does not stand before what is seen behind it.

    Landmarks tell nothing of what is beside and behind the jaw, and a usual head is wider there than drawings with long
    jaws are. In rounds what is on the outline of the head and before what is labelled background is pulled, at its
    depth, to the nearest of the labelled head, and the surface bends between it, landmarks, ears and skull.

    face: Face with the camera of the picture. template: of its topology. picture: with its regions. anchors: (L,)
    vertices of the landmarks, which stay.
    Returns the same Face where it stands before nothing.
    """
    if picture.regions is None:
        return face
    regions, camera = smaller_labels(picture.regions, face.require_camera(), face.vertices, _SETTINGS.height)
    sides = _Sides(template, camera, regions, anchors)
    vertices = np.array(face.vertices, float)
    for _ in range(_SETTINGS.rounds):
        moves = sides.pulled(vertices)
        if moves is None:
            break
        vertices += moves
    return face if np.array_equal(vertices, face.vertices) else face.with_vertices(vertices)


class _Sides:
    """A head of a template in its label map."""

    def __init__(self, template: Template, camera: Camera, regions: np.ndarray, anchors: np.ndarray) -> None:
        """camera: of the label map regions (H, W), values of Region. anchors: (L,) vertices that stay."""
        self.camera = camera
        self.regions = regions
        ears = template.mask(*EARS)
        height = template.vertices[:, 1]
        self.skull = template.mask(*_SKULL) & (height > height[ears].mean() if ears.any() else True)
        self.fixed = ears.copy()
        self.fixed[anchors] = True
        self.faces = template.faces[~ears[template.faces].any(1)]
        self.template = template
        head = ~np.isin(regions, _NO_HEAD)
        self.ends = np.argwhere(head & widen_mask(~head, 1))[:, ::-1]

    def pulled(self, vertices: np.ndarray) -> np.ndarray | None:
        """(V, 3) metres, by which a head (V, 3) comes in, or None where it need not."""
        rows, columns = self.regions.shape
        placed = self.camera.place(vertices)
        height = float(np.ptp(placed[:, 1]))
        covered = covered_pixels(placed, self.faces, columns, rows)
        rim = np.argwhere(covered & widen_mask(~covered, 1))[:, ::-1]
        if not len(rim) or not len(self.ends):
            return None
        places = placed[:, :2]
        column, row = np.clip(np.rint(places).astype(int), 0, [columns - 1, rows - 1]).T
        shown = (np.rint(places) == np.column_stack([column, row])).all(1)
        outer = KDTree(rim).query(places)[0] < max(_SETTINGS.near * height, 1.5)
        before = outer & shown & (self.regions[row, column] == Region.BACKGROUND)
        away, nearest = KDTree(self.ends).query(places)
        away /= height
        ends = self.ends[nearest]
        pulls = before & ~self.fixed & ~self.skull & covered[*ends.T[::-1]]
        pulls &= (away > _SETTINGS.slight) & (away < _SETTINGS.far)
        if away[pulls].max(initial=0) < _SETTINGS.least:
            return None
        stays = np.maximum(np.where(self.skull, _SETTINGS.skull, _LOOSE), _SETTINGS.rim * (outer & ~before))
        weights = np.where(pulls | self.fixed, 1.0, stays)
        wanted = np.where(pulls[:, None], (ends - places) / self.camera.scale, 0)
        cost = bending(self.template)
        stiff = _SETTINGS.stiffness / cost.diagonal().mean() * cost
        moves: np.ndarray = Cholesky((sp.diags(weights) + stiff).tocsc()).solve(wanted)
        return moves @ self.camera.rotation[:2]
