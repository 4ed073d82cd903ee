"""A texture from the picture that a face was fitted to (portrait paper, section 3.2.3), right from every side."""

from dataclasses import dataclass

import cv2
import numpy as np
import scipy.sparse as sp
from scipy.ndimage import distance_transform_edt

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.triangulate import triangulate
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.render.diffuse_background import diffuse_background
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_pixels
from caricli.render.smooth_normals import smooth_normals
from caricli.render.uv_map import pad_texture, uv_map
from caricli.template.template import CAVITIES

GRAZING, FACING = 0.12, 0.5
MIRRORED = 0.08
BEHIND = 0.006
_EDGE, _TRUST, _HOLD, _FAINT = 0.012, 0.35, 1e4, 1e-6
_BUFFER = 1024


@dataclass(frozen=True, eq=False)
class FaceTexture:
    """image (S, S, 3) uint8 sRGB, the top row first; seen (S, S) float32, from 0 where a texel is made up to 1 where
    the picture shows it; covered (S, S) bool, texels of the surface."""

    image: np.ndarray
    seen: np.ndarray
    covered: np.ndarray


def texture_face(vertices, pose, image, mask, mesh, size=1024):
    """Paint a face with its picture where the picture shows it, and plausibly elsewhere.

    A texel takes the colour at its projection as far as it is seen, not at a grazing angle, and not near the border of
    the mask; where it is not, that of its mirror image, if this is; the rest is filled by diffusion over the surface
    from what is known. Background never enters: it is replaced by diffused colours of the face first.

    vertices: (V, 3) metres. pose: Pose. image: (H, W, 3) uint8. mask: (H, W) bool, the head. mesh: Template with UVs.
    size: texels, width and height. Returns FaceTexture.
    """
    view = _View(vertices, pose, image, mask, mesh.faces)
    uv_faces = triangulate(mesh.uv_polygons)
    face, weights = uv_map(mesh.uvs, uv_faces, size)
    covered = face >= 0
    corners, weights = mesh.faces[face[covered]], weights[covered].astype(np.float64)

    def blend(values, ids):
        return np.einsum("nk,nkc->nc", weights, values[ids])

    normals = smooth_normals(vertices, mesh.faces)
    pockets = mesh.mask(*CAVITIES).astype(np.float64)
    colours, seen = view.look(blend(vertices, corners), blend(normals, corners), (weights * pockets[corners]).sum(1))
    known, certain = view.look(vertices, normals, pockets)
    mirror = mesh.annotation.mirror
    if mirror is not None:
        place = mirror[corners]
        pocket = (weights * pockets[place]).sum(1)
        other, other_seen = view.look(blend(vertices, place), blend(normals, place), pocket)
        colours, seen = _completed(colours, seen, other, other_seen)
        known, certain = _completed(known, certain, known[mirror], certain[mirror])
    filled = blend(_spread(known, certain, mesh.faces), corners)
    trust = np.clip(seen / _TRUST, 0, 1)[:, None]
    trust = trust * trust * (3 - 2 * trust)
    picture, shown = np.zeros((size, size, 3)), np.zeros((size, size), np.float32)
    picture[covered] = trust * colours + (1 - trust) * filled
    shown[covered] = trust[:, 0]
    picture = np.clip(np.round(pad_texture(picture, covered)), 0, 255).astype(np.uint8)
    return FaceTexture(picture, shown, covered)


def _completed(colours, seen, other, other_seen):
    """Colours (N, 3), and how far they are known (N,), with those of the other side where these are hardly seen."""
    share = seen / np.maximum(seen + MIRRORED * other_seen, 1e-9)
    return share[:, None] * colours + (1 - share[:, None]) * other, np.maximum(seen, other_seen * (1 - share))


class _View:
    """What the picture shows of points of a surface."""

    def __init__(self, vertices, pose, image, mask, faces):
        self.pose, self.height = pose, float(np.ptp(vertices[:, 1]))
        self.pictured = diffuse_background(image, mask)
        # Texels near the border of the mask would show the outline of the drawing or what is behind it.
        reach = _EDGE * pose.scale * self.height
        inside = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
        self.inside = np.clip(inside / max(reach, 1.0) - 0.5, 0, 1).astype(np.float32)
        # Visibility needs no more pixels than the mesh has detail.
        rows, columns = mask.shape
        self.zoom = min(1.0, _BUFFER / max(rows, columns))
        size = round(columns * self.zoom), round(rows * self.zoom)
        self.depth = rasterise(pose.place(vertices) * self.zoom, faces, *size).depth

    def look(self, points, normals, pocket):
        """Colours (N, 3) and how far (N,) from 0 to 1 points with normals (N, 3) are seen.

        pocket: (N,) from 0 to 1, in the mouth or an eye socket: nobody looks there from the side.
        """
        placed = self.pose.place(points)
        x, y = placed[:, 0], placed[:, 1]
        colours = sample_pixels(self.pictured, x, y).astype(np.float64)
        inside = sample_pixels(self.inside, x, y, border=0.0)
        nearest = sample_pixels(self.depth, self.zoom * x, self.zoom * y, cv2.INTER_NEAREST, float("inf"))
        behind = placed[:, 2] - nearest / self.zoom
        lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-9)
        cosine = -(normals @ self.pose.rotation[2]) / lengths
        # A surface at an angle is behind itself by the width of a pixel.
        allowed = BEHIND * self.pose.scale * self.height / np.clip(cosine, 0.2, 1)
        facing = np.clip((cosine - GRAZING) / (FACING - GRAZING), 0, 1) ** 2
        return colours, np.maximum(facing, pocket) * inside * (behind < allowed)


def _spread(colours, certain, faces):
    """(V, 3) colours of vertices, those that are not known the smoothest continuation of the others."""
    adjacency, _ = vertex_neighbours(faces, len(colours))
    laplacian = sp.diags(np.asarray(adjacency.sum(1)).ravel()) - adjacency
    hold = _HOLD * certain**2
    usual = np.average(colours, axis=0, weights=certain + 1e-9)
    return Cholesky(laplacian + sp.diags(hold + _FAINT)).solve(hold[:, None] * colours + _FAINT * usual)
