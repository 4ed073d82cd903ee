"""The line along upper lids: of lashes in a photograph, of ink in a drawing."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import KDTree

from caricli.geometry.lines.along_lines import along
from caricli.geometry.smooth_step import smooth_step
from caricli.render.eyes.eye_window import WIDTH, EyeWindow, eye_windows
from caricli.render.pixels.paint import mix
from caricli.render.visibility.uv_map import uv_map
from caricli.structures import Mesh
from caricli.template.template import Template

# Lengths are shares of the eye's width.
_WINDOW = 3.0  # side of what is looked at
_STEP = 0.01
_NEAR = 0.12  # of the lid, as far as its line is looked for
_SKIN = (0.05, 0.3)  # above the lid, where skin is that it is darker than
_LIGHT = 0.75  # quantile of that skin's brightness: folds and brows are darker
_CORNERS = ((0.1, 0.32), (0.68, 0.9))  # of the way along the lid: between them an iris may be as dark
_DARK = (0.55, 0.2)  # of the skin's brightness: from where on what is darker is a line, and with which it surely is
_WIDTHS = (0.03, 0.09)
_EDGE = (1.25, 0.5)  # of the width from the lid: from where on and with which there is all of the line
_TAPER = 0.12  # of the way along the lid, from either corner, over which it grows as wide as it is
_POINTS = 200  # along a lid


@dataclass(frozen=True, eq=False)
class LidLine:
    """A line along upper lids. colour: (3,) sRGB, 0 to 255. strength: from 0 to 1. width: share of the eye's."""

    colour: np.ndarray
    strength: float
    width: float


def seen_lid_line(image: np.ndarray, points: np.ndarray) -> LidLine | None:
    """Look for the line along the upper lids of a face.

    It is darker than the skin above it, next to both corners of an eye, where no iris is below it.

    image: (H, W, 3) uint8. points: (L, 2) landmarks, pixels, NaN where unknown.
    Returns LidLine, the mean of both eyes by how strong theirs are, or None where neither shows one.
    """
    lines = [_of_eye(window) for window in eye_windows(image, points, _WINDOW)]
    strengths = [line.strength for line in lines]
    if not any(strengths):
        return None
    colour = np.average([line.colour for line in lines], axis=0, weights=strengths)
    width = np.average([line.width for line in lines], weights=strengths)
    return LidLine(colour, float(np.mean(strengths)), float(width))


def draw_lid_lines(picture: np.ndarray, head: Template, line: LidLine) -> np.ndarray:
    """(S, S, 3) uint8: a head's texture (S, S, 3) uint8 with a LidLine along its upper lids, on them and on their rims.

    head: Template with UVs; where its annotation names no lids there is no line.
    """
    drawn = picture.copy()
    for side in ("left", "right"):
        if f"eye_upper_{side}" in head.annotation.curves:
            rows, columns, share = _along_lid(head, side, line, len(picture))
            drawn[rows, columns] = np.round(mix(drawn[rows, columns].astype(float), line.colour, share))
    return drawn


def _of_eye(window: EyeWindow) -> LidLine:
    """What is the darkest along the upper lid of an eye."""
    lid = window.outline[:4]
    shares = np.concatenate([np.linspace(*part, 10) for part in _CORNERS])
    axis = (lid[3] - lid[0]) / max(np.linalg.norm(lid[3] - lid[0]), 1e-9)
    heights = np.arange(-_NEAR, _SKIN[1], _STEP)
    ways = along(lid[None], shares[None])[0][:, None] + WIDTH * heights[:, None] * np.array([axis[1], -axis[0]])
    x, y = np.moveaxis(ways.astype(np.float32), 2, 0)
    colours = cv2.remap(window.picture, x, y, cv2.INTER_LINEAR).astype(float)
    light = colours.mean(-1)
    skin = np.quantile(light[:, heights >= _SKIN[0]], _LIGHT, axis=1)
    each = np.arange(len(shares))
    darkest = light[:, heights <= _NEAR].argmin(1)
    least = light[each, darkest]
    above = (light >= (skin + least)[:, None] / 2) & (np.arange(len(heights)) > darkest[:, None])
    widths = _STEP * (above.argmax(1) - darkest)
    strength = float(smooth_step(float(np.median(least / np.maximum(skin, 1))), *_DARK))
    return LidLine(np.median(colours[each, darkest], axis=0), strength, float(np.clip(np.median(widths), *_WIDTHS)))


def _along_lid(head: Template, side: str, line: LidLine, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and shares (N,) of the texels of a texture of a size that a line along one lid colours."""
    lid = head.vertices[head.annotation.curves[f"eye_upper_{side}"]]
    width = line.width * np.linalg.norm(lid[-1] - lid[0])
    shares = np.linspace(0, 1, _POINTS)
    tree = KDTree(along(lid[None], shares[None])[0])
    corners = head.vertices[head.faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(1)
    near = tree.query(corners.mean(1))[0] < _EDGE[0] * width + edges
    near &= ~head.mask(f"eye_socket_{side}")[head.faces].all(1)
    part = Mesh(head.vertices, head.faces[near], head.uvs, head.uv_faces[near])
    face, weights = uv_map(part, size)
    rows, columns = np.nonzero(face >= 0)
    places = np.einsum("nk,nkc->nc", weights[rows, columns], head.vertices[part.faces[face[rows, columns]]])
    away, nearest = tree.query(places)
    ends = np.minimum(shares, 1 - shares)[nearest] / _TAPER
    return rows, columns, line.strength * smooth_step(away, *(width * np.clip(ends, 0.05, 1) * e for e in _EDGE))
