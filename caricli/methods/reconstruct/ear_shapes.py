"""Outlines that ears can have in a picture, and how well the picture agrees with them."""

import numpy as np

from caricli.methods.reconstruct.outline import SIDES
from caricli.methods.reconstruct.picture_evidence import PictureEvidence
from caricli.methods.reconstruct.settings import EarSettings
from caricli.structures import Face
from caricli.template.template import Template

_THINNEST = 0.12  # of an ear's height: one that lies on the head is seen as wide as that at least
_WIDEST = 3.0  # heights of the fitted ear: wider than this no ear is


class EarShapes:
    """Ears on one side of a fitted face in a window, as rows of seven numbers.

    Shift outwards of where it is fixed, in heights of the fitted ear; logarithms of width and height in pixels; its
    middle above where the fitted one is fixed, in heights of this; how far its outer rim is raised, per width; how far
    it bulges below or above its middle; how far its top leans out, per height. Those of the fitted ear are ``fitted``;
    ``away`` are degrees by which it is turned away from the camera, negative for one that is turned towards it.
    """

    def __init__(self, face: Face, template: Template, side: str, window: PictureEvidence) -> None:
        """face: Face with the camera of the picture. template: with curves of the ears. side: of SIDES."""
        camera = face.require_camera()
        curve = template.annotation.curves[f"ear_{side}"]
        sign = 1 if side == "left" else -1
        up = camera.rotation[:2, 1] / np.linalg.norm(camera.rotation[:2, 1])
        out = np.array([-up[1], up[0]])
        self.axes = np.stack([out * np.sign(sign * out @ camera.rotation[:2, 0] or 1), up])
        rim = window.to_window(camera.project(face.vertices[curve]))
        self.root = (rim[0] + rim[-1]) / 2
        local = (rim - self.root) @ self.axes.T
        self.height = max(float(np.ptp(local[:, 1])), 1.0)
        width = max(float(local[:, 0].max()), _THINNEST * self.height)
        middle = (local[:, 1].max() + local[:, 1].min()) / 2
        self.fitted = np.array([0, np.log(width), np.log(self.height), middle / self.height, 0, 0, 0])
        self.plain = _plain_rim(template.vertices[curve] * [sign, 1, 1])
        marked = template.vertices[template.annotation.landmarks[SIDES[side]]]
        self.standing = np.linalg.norm(template.vertices[curve] - marked[:, None], axis=2).argmin(1)
        self.away = sign * float(np.degrees(np.arctan2(camera.rotation[2, 0], -camera.rotation[2, 2])))

    def rims(self, ears: np.ndarray) -> np.ndarray:
        """(N, R, 2) pixels of the window, the outlines of ears (N, 7), from above to below where they are fixed."""
        shift, width, height, middle, raised, bulge, lean = ears.T[..., None]
        along = self.plain[:, 1]
        along = along + bulge * (1 - 4 * along**2)
        outwards = np.exp(width) * self.plain[:, 0]
        upwards = self.height * middle + np.exp(height) * along + raised * outwards
        outwards = outwards + self.height * shift + lean * np.exp(height) * along
        return self.root + outwards[..., None] * self.axes[0] + upwards[..., None] * self.axes[1]

    def landmarks(self, ears: np.ndarray) -> np.ndarray:
        """(N, 3, 2) pixels of the window: top, outer and lobe of ears (N, 7)."""
        return self.rims(ears)[:, self.standing]

    def sizes(self, ears: np.ndarray) -> np.ndarray:
        """(N,) heights of ears (N, 7) in those of the fitted one."""
        return np.exp(ears[:, 2]) / self.height

    def limited(self, ears: np.ndarray) -> np.ndarray:
        """Ears (N, 7), none of them wider than ears are."""
        limit = np.full(ears.shape[1], np.inf)
        limit[1] = np.log(_WIDEST * self.height)
        return np.minimum(ears, limit)


def agreement(
    shapes: EarShapes, ears: np.ndarray, window: PictureEvidence, settings: EarSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How much a picture has of what ears (N, 7) should show, means along their rims.

    Returns (N,) colour inside, from -1 to 1, the same outside, and edge from 0 to 1. What the landmarks enclose is no
    ear, but may hide one that is turned away.
    """
    rims = shapes.rims(ears)
    along = np.gradient(rims, axis=1)
    normals = np.stack([along[..., 1], -along[..., 0]], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True) + 1e-9
    centres = rims.mean(1, keepdims=True)
    normals *= np.sign(((rims - centres) * normals).sum((1, 2)))[:, None, None]
    # The ends of the rim are where the ear begins.
    rims = rims[:, 1:-1]
    normals = normals[:, 1:-1]
    hidden = 0.0 if shapes.away > settings.hidden_from else -1.0
    own = np.where(window.inside, hidden, window.skin)
    other = np.where(window.inside, 0.0, window.skin)
    inner = (_read(own, rims - settings.near * normals) + _read(own, (rims + centres) / 2)) / 2
    outer = (_read(other, rims + settings.near * normals) + _read(other, rims + settings.far * normals)) / 2
    edge = np.tanh(np.abs((_read(window.gradient, rims) * normals).sum(-1)) / settings.strong)
    return inner.mean(1), outer.mean(1), edge.mean(1)


def _read(picture: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Values of a picture (H, W) or (H, W, C) at the pixels nearest to places (..., 2); 0 outside."""
    column, row = np.moveaxis(np.rint(places).astype(int), -1, 0)
    height, width = picture.shape[:2]
    within = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    values = picture[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    return np.where(within if picture.ndim == 2 else within[..., None], values, 0)


def _plain_rim(rim: np.ndarray) -> np.ndarray:
    """(R, 2) the outline of an ear, outwards from 0 to 1 and upwards from -1/2 to 1/2: half what is seen from the side,
    half what is seen from the front of a rim (R, 3) on the left.
    """
    ends = rim[[0, -1]].mean(0)
    side = (ends[2] - rim[:, 2]) / max(ends[2] - rim[:, 2].min(), 1e-9)
    front = (rim[:, 0] - ends[0]) / max(rim[:, 0].max() - ends[0], 1e-9)
    out = (side + np.maximum(front, 0)) / 2
    out -= (out[0] + out[-1]) / 2
    middle = (rim[:, 1].max() + rim[:, 1].min()) / 2
    return np.stack([out / max(out.max(), 1e-9), (rim[:, 1] - middle) / max(np.ptp(rim[:, 1]), 1e-9)], 1)
