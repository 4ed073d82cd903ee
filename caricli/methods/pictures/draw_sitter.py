"""One head before a camera, in any light, with all that is known of the picture."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.geometry.head_rotation import head_rotation
from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.settings import PoseSettings
from caricli.methods.pictures.sitter import Sitter
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.render.rasterise import Raster, rasterise
from caricli.render.sky import DIRECTIONS
from caricli.structures.parsing import Region

_TOLERANCE = 0.02  # of the head's height: a landmark that is so far behind what is seen at its pixel is seen itself
_STRAND_PIXELS = 256
_CAP = 0.3  # cosine from the gaze: an eyeball shows no more than this of its front
COVERING = (Region.HAIR, Region.BEARD, Region.GLASSES, Region.HAT, Region.CLOTH)
"""What hides skin where it is seen."""


@dataclass(frozen=True, eq=False)
class Pose:
    """How a head stands before the camera: a pixel is ``scale * f * (rotation @ p)[:2] + translation``.

    rotation: (3, 3) from the face's axes to the camera's. scale: pixels a metre. translation: (2,) pixels.
    perspective: f = 1 / (1 + perspective * depth), depth in heights of the head behind its middle.
    """

    rotation: np.ndarray
    scale: float
    translation: np.ndarray
    perspective: float
    middle: np.ndarray
    height: float

    def place(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) pixels and depth, in pixels too, of points (N, 3) metres."""
        turned = (points - self.middle) @ self.rotation.T
        nearer = 1 / (1 + self.perspective * turned[:, 2:] / self.height)
        return np.column_stack([self.scale * nearer * turned[:, :2] + self.translation, self.scale * turned[:, 2]])


@dataclass(frozen=True, eq=False)
class Drawing:
    """A head as it is seen, before anything else.

    colours: (S, S, 3) float32 linear light. region: (S, S) uint8 Region, BACKGROUND where the head is not.
    depth: (S, S) pixels. points: (L, 2) pixels. visible: (L,).
    pose: Pose.
    """

    colours: np.ndarray
    region: np.ndarray
    points: np.ndarray
    visible: np.ndarray
    pose: Pose


def random_pose(
    sitter: Sitter, size: int, filled: float, generator: np.random.Generator, settings: PoseSettings, away: bool = False
) -> Pose:
    """Draw a Pose. filled: longer side of the landmarks' box, of the picture's. away: seen from behind."""
    yaw = generator.normal(0, settings.yaw)
    if generator.random() < settings.turned:
        yaw = generator.uniform(-settings.farthest, settings.farthest)
    yaw = np.clip(yaw, -settings.farthest, settings.farthest) + (180 if away else 0)
    roll = generator.normal(0, settings.roll)
    if generator.random() < settings.rolled:
        roll = generator.uniform(-settings.roll_far, settings.roll_far)
    rotation = head_rotation(np.radians([generator.normal(0, settings.pitch), yaw, roll]))
    marks = sitter.skin.vertices[sitter.skin.annotation.landmarks[:68]]
    middle = sitter.skin.vertices.mean(0)
    flat = (marks - middle) @ rotation[:2].T
    scale = filled * size / max(np.ptp(flat, axis=0).max(), 1e-6)
    room = max(0.5 - filled / 2, 0) + 0.06
    aside = generator.uniform(-1, 1, 2) * (settings.aside if filled > 0.3 else room)
    centre = scale * (flat.min(0) + flat.max(0)) / 2
    translation = size * (0.5 + aside) - centre
    height = float(np.ptp(sitter.skin.vertices[:, 1]))
    return Pose(rotation, float(scale), translation, float(generator.uniform(0, settings.perspective)), middle, height)


def draw_sitter(
    sitter: Sitter, pose: Pose, size: int, sky: Sky, generator: np.random.Generator, strands: np.ndarray
) -> Drawing:
    """Draw a head.

    size: pixels. strands: (S, S) brightness of hair around 1, a picture without borders. Returns a Drawing.
    """
    pieces = sitter.pieces
    placed = pose.place(pieces.vertices)
    corners = placed[pieces.faces]
    along = corners[:, 1, :2] - corners[:, 0, :2]
    across = corners[:, 2, :2] - corners[:, 0, :2]
    # With y down, triangles that are seen from outside go the other way round.
    outside = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] < 0
    faces = pieces.faces[outside | pieces.thin]
    raster = rasterise(placed, faces, size, size)
    covered = raster.face >= 0
    triangles = faces[raster.face[covered]]
    weights = raster.barycentric[covered]
    colours = np.zeros((size, size, 3), np.float32)
    light = _light(sitter, pose, sky, generator)
    colours[covered] = np.einsum("nk,nkc->nc", weights, light[triangles])
    region = np.zeros((size, size), np.uint8)
    region[covered] = pieces.region[triangles[np.arange(len(triangles)), weights.argmax(1)]]
    colours[covered] *= _strands(pieces.strands, triangles, weights, strands)[:, None]
    _draw_eyes(colours, region, raster, sitter, pose, sky, generator)
    points, visible = _landmarks(sitter, pose, raster, region)
    return Drawing(colours, region, points, visible, pose)


def _light(sitter: Sitter, pose: Pose, sky: Sky, generator: np.random.Generator) -> np.ndarray:
    """(W, 3) float32 linear light that comes from the vertices."""
    radiance = sky.radiance(DIRECTIONS @ pose.rotation.T).astype(np.float32)
    received = sitter.transfer @ radiance
    colours = sitter.pieces.colours * received
    normals = sitter.normals @ pose.rotation.T
    half = sky.ways[0] + [0, 0, -1]
    half /= max(np.linalg.norm(half), 1e-6)
    shine = np.maximum(normals @ half, 0) ** generator.uniform(12, 60) * sitter.pieces.gloss
    colours += shine[:, None] * sky.colours[0] * np.minimum(received.mean(1), 1)[:, None]
    toward = -normals[:, 2]
    if generator.random() < 0.3:  # dark outlines, as painters do
        colours *= (1 - generator.uniform(0.3, 0.9) * np.clip((0.45 - toward) / 0.45, 0, 1))[:, None]
    return colours.astype(np.float32)


def _strands(places: np.ndarray, triangles: np.ndarray, weights: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """(N,) brightness of the strands that pixels show, one where there are none."""
    at = np.einsum("nk,nkc->nc", weights, places[triangles])
    shown = np.isfinite(at).all(1)
    column, row = (np.floor(_STRAND_PIXELS * np.nan_to_num(at)) % _STRAND_PIXELS).astype(int).T
    return np.where(shown, strands[row, column], 1.0).astype(np.float32)


def _draw_eyes(
    colours: np.ndarray,
    region: np.ndarray,
    raster: Raster,
    sitter: Sitter,
    pose: Pose,
    sky: Sky,
    generator: np.random.Generator,
) -> None:
    """Draw the eyeballs where nothing is before them."""
    size = len(colours)
    gaze = np.array([generator.normal(0, 0.18), generator.normal(0, 0.1), 1.0])
    gaze = pose.rotation @ (gaze / np.linalg.norm(gaze))
    front = pose.rotation @ np.array([0.0, 0.0, 1.0])
    pupil = sitter.iris_size * generator.uniform(0.3, 0.6)
    white = np.array([0.78, 0.74, 0.70]) * generator.uniform(0.7, 1.15)
    radiance = sky.radiance(DIRECTIONS)
    glint = sky.ways[0] + [0, 0, -1]
    glint /= max(np.linalg.norm(glint), 1e-6)
    for centre, radius in sitter.eyeballs:
        x, y, z = pose.place(centre[None])[0]
        nearer = 1 / (1 + pose.perspective * z / pose.scale / pose.height)
        reach = radius * pose.scale * nearer
        top, bottom = (int(np.clip(value, 0, size)) for value in (np.floor(y - reach), np.ceil(y + reach) + 1))
        left, right = (int(np.clip(value, 0, size)) for value in (np.floor(x - reach), np.ceil(x + reach) + 1))
        rows, columns = np.mgrid[top:bottom, left:right]
        dx = (columns - x) / reach
        dy = (rows - y) / reach
        inside = 1 - dx**2 - dy**2
        normal = np.stack([dx, dy, -np.sqrt(np.maximum(inside, 0))], -1)
        seen = (inside > 0) & (z + reach * normal[..., 2] < raster.depth[top:bottom, left:right])
        seen &= normal @ front > _CAP
        away = np.arccos(np.clip(normal[seen] @ gaze, -1, 1))
        albedo = np.where((away < sitter.iris_size)[:, None], sitter.iris, white)
        albedo = np.where((away < pupil)[:, None], 0.008, albedo)
        received = 4 / len(DIRECTIONS) * np.maximum(normal[seen] @ DIRECTIONS.T, 0) @ radiance
        shadow = np.clip(0.95 + 0.55 * normal[seen][:, 1:2], 0.35, 1)
        mirrored = (np.linalg.norm(normal[seen] - glint, axis=1) < 0.16)[:, None]
        colours[top:bottom, left:right][seen] = np.where(mirrored, 0.95, albedo * received * shadow)
        region[top:bottom, left:right][seen] = Region.EYES


def _landmarks(sitter: Sitter, pose: Pose, raster: Raster, region: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (L, 2) of the landmarks, and which of them (L,) are seen."""
    skin = sitter.skin
    ids = landmark_vertices(skin.vertices, pose.rotation, skin, len(skin.annotation.landmarks))
    placed = pose.place(skin.vertices[ids])
    size = len(region)
    column, row = np.round(placed[:, :2]).astype(int).T
    inside = (column >= 0) & (column < size) & (row >= 0) & (row < size)
    depth = cv2.dilate(np.where(np.isfinite(raster.depth), raster.depth, 1e6).astype(np.float32), np.ones((3, 3)))
    at = np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)
    behind = depth[at] < placed[:, 2] - _TOLERANCE * pose.height * pose.scale
    return placed[:, :2], inside & ~behind & ~np.isin(region[at], COVERING)


def random_strands(generator: np.random.Generator) -> np.ndarray:
    """Draw brightness (S, S) of hair around 1, fine across and long along, a picture without borders."""
    noise = generator.normal(size=(_STRAND_PIXELS, _STRAND_PIXELS))
    frequency = np.fft.fftfreq(_STRAND_PIXELS) * _STRAND_PIXELS
    along, across = np.meshgrid(frequency, frequency, indexing="ij")
    keep = np.exp(-((along / 4) ** 2)) / (1 + (np.abs(across) / 50) ** 2)
    filtered = np.real(np.fft.ifft2(np.fft.fft2(noise) * keep))
    return np.clip(1 + 0.35 * filtered / filtered.std(), 0.2, 2.2).astype(np.float32)
