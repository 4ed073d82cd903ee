"""Ears whose outline is that of the ears in their picture."""

from dataclasses import dataclass

import cv2
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

_BEHIND = (Region.BACKGROUND, Region.CLOTH)
"""What an ear ends before; hair may cover more of it."""


@dataclass(frozen=True)
class EarOutlineSettings:
    """How ears follow their outline.

    height: pixels of the head, to which larger pictures are made smaller. stiffness: of the ear against bending, in
    that of one point that pulls. rounds: of pulling. sizes: of the labelled ear to the fitted one, between which it is
    the same. border: pixels of its outline that are seen at least, of the square root of its area. far: of that, from
    where on nothing pulls. near: of the head's height, how near to the outline vertices are that follow.
    """

    height: int = 500
    stiffness: float = 10000.0
    rounds: int = 10
    sizes: tuple[float, float] = (0.3, 3.0)
    border: float = 1.5
    far: float = 0.35
    near: float = 0.006


_SETTINGS = EarOutlineSettings()


def fit_ears(face: Face, template: Template, picture: ParsedPicture) -> Face:
    """A face whose ears end where the labels of its picture have them end.

    Three landmarks tell where an ear is, and nothing of its shape: lobes and rims of drawings are far from usual. In
    rounds what is on the outline of the head's ear is pulled, at its depth, to the nearest border of the labelled one
    before what is behind it, and the ear bends as a plate that is held at the head; where hair covers an ear nothing
    pulls.

    face: Face with the camera of the picture. template: of its topology. picture: with its regions.
    Returns the same Face where no ear is seen that is about as large.
    """
    camera = face.require_camera()
    if picture.regions is None:
        return face
    regions, camera = smaller_labels(picture.regions, camera, face.vertices, _SETTINGS.height)
    vertices = np.array(face.vertices, float)
    places = camera.place(vertices)
    for name, mask in _labelled(template, regions, places[:, :2]).items():
        ear = _Ear(template, name, mask, regions, places)
        for _ in range(_SETTINGS.rounds if ear.is_seen else 0):
            vertices[ear.ids] += ear.pulled(vertices, camera)
    return face if np.array_equal(vertices, face.vertices) else face.with_vertices(vertices)


def _labelled(template: Template, regions: np.ndarray, places: np.ndarray) -> dict[str, np.ndarray]:
    """(H, W) bool by ear: what of the labelled ears is nearer to it than to the other one. places: (V, 2) pixels."""
    names = [name for name in EARS if name in template.annotation.regions]
    count, parts = cv2.connectedComponents((regions == Region.EARS).astype(np.uint8), connectivity=4)
    masks = {name: np.zeros(regions.shape, bool) for name in names}
    for number in range(1, count if names else 0):
        part = parts == number
        middle = np.argwhere(part).mean(0)[::-1]
        away = [np.linalg.norm(places[template.annotation.regions[name]].mean(0) - middle) for name in names]
        masks[names[int(np.argmin(away))]] |= part
    return masks


class _Ear:
    """An ear of a template, and where it is labelled. ids: (E,) its vertices."""

    def __init__(
        self, template: Template, name: str, mask: np.ndarray, regions: np.ndarray, places: np.ndarray
    ) -> None:
        """name: of EARS. mask: (H, W) bool, the labelled ear. regions: (H, W) values of Region. places: (V, 3) pixels,
        where the head's vertices are."""
        self.ids = template.annotation.regions[name]
        self.height = template.height
        own = template.mask(name)[template.faces].all(1)
        self.faces = template.faces[own]
        self.others = covered_pixels(places, template.faces[~own], *mask.shape[::-1])
        self.bending = bending(template)[self.ids][:, self.ids]
        self.mask = mask
        beside = widen_mask(np.isin(regions, _BEHIND), 1)
        self.border = np.argwhere(mask & beside)[:, ::-1].astype(float)
        self.side = float(np.sqrt(cv2.contourArea(cv2.convexHull(places[self.ids, :2].astype(np.float32)))))

    @property
    def is_seen(self) -> bool:
        """Whether what is labelled can be this ear, and shows its outline."""
        low, high = np.array(_SETTINGS.sizes) * self.side**2
        return bool(low < self.mask.sum() < high and len(self.border) > _SETTINGS.border * self.side)

    def pulled(self, vertices: np.ndarray, camera: Camera) -> np.ndarray:
        """(E, 3) metres, by which its vertices of a head (V, 3) bring its outline nearer to the label's."""
        places = camera.place(vertices)
        shown = covered_pixels(places, self.faces, *self.mask.shape[::-1])
        around = widen_mask(~(shown | self.others), 1)
        rim = np.argwhere(shown & around)[:, ::-1]
        if not len(rim):
            return np.zeros((len(self.ids), 3))
        own = places[self.ids, :2]
        reach = max(_SETTINGS.near * self.height * camera.scale, 1.5)
        away, nearest = KDTree(self.border).query(own)
        follows = (KDTree(rim).query(own)[0] < reach) & (away < _SETTINGS.far * self.side)
        gaps = (self.border[nearest] - own) / camera.scale
        wanted = np.where(follows[:, None], gaps, 0) @ camera.rotation[:2]
        stiff = _SETTINGS.stiffness / self.bending.diagonal().mean() * self.bending
        return Cholesky((sp.diags(follows.astype(float)) + stiff).tocsc()).solve(wanted)
