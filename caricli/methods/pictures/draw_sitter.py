"""One head before a camera, in any light, with all that is known of the picture."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.pictures.eyes import Canvas, draw_eyes
from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.sitter import Sitter
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.texture.estimate_light import harmonics
from caricli.render.sky import DIRECTIONS
from caricli.render.visibility.rasterise import rasterise
from caricli.structures.parsing import Region

_TOLERANCE = 0.02  # of the head's height: a landmark that is so far behind what is seen at its pixel is seen itself
_STRAND_PIXELS = 256
COVERING = (Region.HAIR, Region.BEARD, Region.GLASSES, Region.HAT, Region.CLOTH)
"""What hides skin where it is seen."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A head as it is seen, before anything else.

    colours: (S, S, 3) float32 linear light. region: (S, S) uint8 Region, BACKGROUND where the head is not.
    points: (L, 2) pixels. visible: (L,).
    pose: Pose.
    """

    colours: np.ndarray
    region: np.ndarray
    points: np.ndarray
    visible: np.ndarray
    pose: Pose


def draw_sitter(
    sitter: Sitter, pose: Pose, size: int, sky: Sky, strands: np.ndarray, generator: np.random.Generator
) -> Drawing:
    """Draw a head.

    size: pixels. strands: (S, S) brightness of hair around 1, a picture without borders. Returns a Drawing.
    """
    pieces = sitter.pieces
    placed = pose.place(pieces.vertices)
    shown = np.flatnonzero(_seen_from_outside(placed, pieces.faces) | pieces.thin)
    faces = pieces.faces[shown]
    raster = rasterise(placed, faces, size, size)
    covered = raster.face >= 0
    triangles = faces[raster.face[covered]]
    weights = raster.barycentric[covered]
    canvas = Canvas(np.zeros((size, size, 3), np.float32), np.zeros((size, size), np.uint8), raster.depth)
    light = _light(sitter, pose, sky, generator)
    brightness = _brightness(pieces.strands, triangles, weights, strands)
    canvas.colours[covered] = brightness[:, None] * np.einsum("nk,nkc->nc", weights, light[triangles])
    if sitter.creases is not None:
        canvas.colours[covered] *= _folds(sitter, pose, sky, shown[raster.face[covered]], weights)
    canvas.region[covered] = pieces.region[triangles[np.arange(len(triangles)), weights.argmax(1)]]
    draw_eyes(canvas, sitter.eyes, pose, sky, generator)
    points, visible = _landmarks(sitter, pose, canvas)
    return Drawing(canvas.colours, canvas.region, points, visible, pose)


def _folds(sitter: Sitter, pose: Pose, sky: Sky, triangles: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(N, 3) by how much folds change the light from triangles (N,), at weights (N, 3) of their corners."""
    assert sitter.creases is not None
    factors = np.ones((len(triangles), 3), np.float32)
    skin = triangles < len(sitter.creases.ground.faces)
    corners = sitter.normals[sitter.pieces.faces[triangles[skin]]]
    normals = np.einsum("nk,nkc->nc", weights[skin], corners)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    radiance = sky.radiance(DIRECTIONS @ pose.rotation.T)
    light = 4 * np.pi / len(DIRECTIONS) * harmonics(DIRECTIONS).T @ radiance
    factors[skin] = sitter.creases.brightness(triangles[skin], weights[skin], normals, light)
    return factors


def _seen_from_outside(placed: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) bool: with y down, triangles that are seen from outside go the other way round."""
    corners = placed[faces]
    along = corners[:, 1, :2] - corners[:, 0, :2]
    across = corners[:, 2, :2] - corners[:, 0, :2]
    return along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] < 0


def _light(sitter: Sitter, pose: Pose, sky: Sky, generator: np.random.Generator) -> np.ndarray:
    """(W, 3) float32 linear light that comes from the vertices."""
    radiance = sky.radiance(DIRECTIONS @ pose.rotation.T).astype(np.float32)
    received = sitter.transfer @ radiance
    colours = sitter.pieces.colours * received
    normals = sitter.normals @ pose.rotation.T
    shine = np.maximum(normals @ sky.half, 0) ** generator.uniform(12, 60) * sitter.pieces.gloss
    colours += shine[:, None] * sky.colours[0] * np.minimum(received.mean(1), 1)[:, None]
    toward = -normals[:, 2]
    if generator.random() < 0.3:  # dark outlines, as painters do
        colours *= (1 - generator.uniform(0.3, 0.9) * np.clip((0.45 - toward) / 0.45, 0, 1))[:, None]
    return colours.astype(np.float32)


def _brightness(places: np.ndarray, triangles: np.ndarray, weights: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """(N,) brightness of the strands that pixels show, one where there are none."""
    corners = places[triangles]
    # The picture has no borders: a triangle over one is as narrow as its neighbours.
    corners = corners - np.round(corners - corners[:, :1])
    at = np.einsum("nk,nkc->nc", weights, corners)
    shown = np.isfinite(at).all(1)
    column, row = (np.floor(_STRAND_PIXELS * np.nan_to_num(at)) % _STRAND_PIXELS).astype(int).T
    return np.where(shown, strands[row, column], 1.0).astype(np.float32)


def _landmarks(sitter: Sitter, pose: Pose, canvas: Canvas) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (L, 2) of the landmarks, and which of them (L,) are seen."""
    skin = sitter.skin
    ids = landmark_vertices(skin.vertices, pose.rotation, skin, len(skin.annotation.landmarks))
    placed = pose.place(skin.vertices[ids])
    size = len(canvas.region)
    column, row = np.round(placed[:, :2]).astype(int).T
    inside = (column >= 0) & (column < size) & (row >= 0) & (row < size)
    depth = cv2.dilate(np.where(np.isfinite(canvas.depth), canvas.depth, 1e6).astype(np.float32), np.ones((3, 3)))
    at = np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)
    behind = depth[at] < placed[:, 2] - _TOLERANCE * pose.height * pose.scale
    return placed[:, :2], inside & ~behind & ~np.isin(canvas.region[at], COVERING)


def random_strands(generator: np.random.Generator) -> np.ndarray:
    """Draw brightness (S, S) of hair around 1, fine across and long along, a picture without borders."""
    noise = generator.normal(size=(_STRAND_PIXELS, _STRAND_PIXELS))
    frequency = np.fft.fftfreq(_STRAND_PIXELS) * _STRAND_PIXELS
    along, across = np.meshgrid(frequency, frequency, indexing="ij")
    keep = np.exp(-((along / 4) ** 2)) / (1 + (np.abs(across) / 50) ** 2)
    filtered = np.real(np.fft.ifft2(np.fft.fft2(noise) * keep))
    return np.clip(1 + 0.35 * filtered / filtered.std(), 0.2, 2.2).astype(np.float32)
