"""A texture from the picture that a face was fitted to (portrait paper, section 3.2.3), right from every side."""

from dataclasses import dataclass

import cv2
import numpy as np
import scipy.sparse as sp
from scipy.ndimage import distance_transform_edt

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.triangle_normals import triangle_normals
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.render.diffuse_background import diffuse_background
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_pixels, texture_matrix
from caricli.render.smooth_normals import smooth_normals
from caricli.render.uv_map import pad_texture, uv_map
from caricli.template.template import CAVITIES

GRAZING, FACING = 0.12, 0.5
MIRRORED = 0.08
BEHIND = 0.006
SMALLEST, LARGEST = 1024, 4096
ROUNDS = 8
_EDGE, _TRUST, _HOLD, _FAINT, _ALONE = 0.012, 0.35, 1e4, 1e-6, 0.25
_BUFFER = 2048


@dataclass(frozen=True, eq=False)
class FaceTexture:
    """image (S, S, 3) uint8 sRGB, the top row first; seen (S, S) float32, from 0 where a texel is made up to 1 where
    the picture shows it; covered (S, S) bool, texels of the surface."""

    image: np.ndarray
    seen: np.ndarray
    covered: np.ndarray


def texture_face(vertices, pose, image, mask, mesh, size=None):
    """Paint a face with its picture where the picture shows it, and plausibly elsewhere.

    A texel takes the colour at its projection as far as it is seen, not at a grazing angle, and not near the border of
    the mask; where it is not, that of its mirror image, if this is; the rest is filled by diffusion over the surface
    from what is known. Background never enters: it is replaced by diffused colours of the face first. What a rendering
    blurs of this is then given back to the texels that are seen.

    vertices: (V, 3) metres. pose: Camera. image: (H, W, 3) uint8. mask: (H, W) bool, the head. mesh: Template with UVs.
    size: texels, width and height; where there is none, the power of two, within limits, with which texels of what is
    seen are one to two pixels wide, by their median. Returns FaceTexture.
    """
    uv_faces = mesh.uv_faces
    view = _View(vertices, pose, image, mask, mesh.faces, mesh.uvs[uv_faces])
    size = size or view.size()
    face, weights = uv_map(mesh.uvs, uv_faces, size)
    covered = face >= 0
    corners, weights = mesh.faces[face[covered]], weights[covered].astype(np.float64)

    def blend(values, ids):
        return np.einsum("nk,nkc->nc", weights, values[ids])

    normals = smooth_normals(vertices, mesh.faces)
    pockets = mesh.mask(*CAVITIES).astype(np.float64)
    places = blend(vertices, corners)
    colours, seen = view.look(places, blend(normals, corners), (weights * pockets[corners]).sum(1))
    own = _trust(seen)
    known, certain = view.look(vertices, normals, pockets)
    mirror = mesh.annotation.mirror
    if mirror is not None:
        place = mirror[corners]
        pocket = (weights * pockets[place]).sum(1)
        other, other_seen = view.look(blend(vertices, place), blend(normals, place), pocket)
        colours, seen = _completed(colours, seen, other, other_seen)
        known, certain = _completed(known, certain, known[mirror], certain[mirror])
    trust = _trust(seen)
    colours = trust * colours + (1 - trust) * blend(_spread(known, certain, mesh.faces), corners)
    ids = np.zeros(covered.shape, int)
    ids[covered] = np.arange(len(colours))
    owner, shown = pad_texture(ids, covered), np.zeros((size, size), np.float32)
    shown[covered] = trust[:, 0]
    picture = np.round(view.sharpen(colours, own, places, owner)).astype(np.uint8)[owner]
    return FaceTexture(picture, shown, covered)


def _trust(seen):
    """(N, 1) from 0 to 1, how much of the picture texels take that are seen as far as (N,)."""
    trust = np.clip(seen / _TRUST, 0, 1)[:, None]
    return trust * trust * (3 - 2 * trust)


def _completed(colours, seen, other, other_seen):
    """Colours (N, 3), and how far they are known (N,), with those of the other side where these are hardly seen."""
    share = seen / np.maximum(seen + MIRRORED * other_seen, 1e-9)
    return share[:, None] * colours + (1 - share[:, None]) * other, np.maximum(seen, other_seen * (1 - share))


class _View:
    """What the picture shows of points of a surface."""

    def __init__(self, vertices, pose, image, mask, faces, corners):
        """corners: (F, 3, 2) UVs of the faces; the rest as in `texture_face`."""
        self.pose, self.height, self.corners = pose, float(np.ptp(vertices[:, 1])), corners
        self.pictured = diffuse_background(image, mask)
        # Texels near the border of the mask would show the outline of the drawing or what is behind it.
        reach = _EDGE * pose.scale * self.height
        inside = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
        self.inside = np.clip(inside / max(reach, 1.0) - 0.5, 0, 1).astype(np.float32)
        # More pixels than the largest texture can hold tell nothing.
        rows, columns = mask.shape
        self.zoom = min(1.0, _BUFFER / max(rows, columns))
        size = round(columns * self.zoom), round(rows * self.zoom)
        self.small = cv2.resize(self.pictured, size, interpolation=cv2.INTER_AREA)
        placed = self._shrunk(pose.place(vertices))
        self.raster = rasterise(placed, faces, *size)
        face = self.raster.face
        mask = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        self.pixels = mask & (face >= 0) & (triangle_normals(placed, faces)[face, 2] < 0)
        self.areas = np.abs(np.linalg.det(placed[faces][:, 1:, :2] - placed[faces][:, :1, :2]))

    def _shrunk(self, placed):
        """Places (N, 3) in the smaller picture; its pixels' centres are whole numbers too."""
        return self.zoom * placed + [(self.zoom - 1) / 2, (self.zoom - 1) / 2, 0]

    def size(self):
        """Texels, width and height, none wider than two pixels, by the median over what is seen."""
        face = self.raster.face[self.pixels]
        spans = np.abs(np.linalg.det(self.corners[:, 1:] - self.corners[:, :1]))[face]
        texels = np.median(np.sqrt(self.areas[face] / np.maximum(spans, 1e-12))) if len(face) else SMALLEST
        return int(np.clip(2 ** int(np.log2(max(texels, 1))), SMALLEST, LARGEST))

    def sharpen(self, colours, trust, points, owner):
        """Colours (N, 3) of texels with which a rendering comes nearer to the picture.

        A rendering mixes four texels at every pixel. What then differs from the picture is given back to them, as far
        as each is seen, and to texels between pixels as what it is there; none leaves the colours that the picture has
        next to it. colours: (N, 3) from 0 to 255. trust: (N, 1) from 0 to 1. points: (N, 3) of the texels. owner:
        (S, S) the texel that each place of the texture shows.
        """
        face, weights = self.raster.face[self.pixels], self.raster.barycentric[self.pixels]
        lookup = texture_matrix(owner, len(colours), np.einsum("nk,nkc->nc", weights, self.corners[face]))
        missing, certain = np.zeros(self.small.shape, np.float32), lookup @ trust
        # Only once as far as it is seen: in rounds, what is hardly seen would take on the picture all the same.
        missing[self.pixels] = certain * (self.small[self.pixels] - lookup @ colours)
        sharper, seen = colours.copy(), trust[:, 0] > 0
        colours, trust, lookup = colours[seen], trust[seen], lookup[:, seen]
        back = lookup.T.tocsr()
        total = back @ np.ones((len(face), 1)) + _ALONE
        x, y, _ = self._shrunk(self.pose.place(points[seen])).T
        square = np.ones((3, 3), np.uint8)
        least = np.minimum(sample_pixels(cv2.erode(self.small, square), x, y, cv2.INTER_NEAREST), colours)
        most = np.maximum(sample_pixels(cv2.dilate(self.small, square), x, y, cv2.INTER_NEAREST), colours)
        for _ in range(ROUNDS):
            share = (back @ missing[self.pixels] + _ALONE * sample_pixels(missing, x, y)) / total
            sharper[seen] = np.clip(colours + trust * share, least, most)
            missing[self.pixels] -= lookup @ (sharper[seen] - colours)
            colours = sharper[seen]
        return sharper

    def look(self, points, normals, pocket):
        """Colours (N, 3) and how far (N,) from 0 to 1 points with normals (N, 3) are seen.

        pocket: (N,) from 0 to 1, in the mouth or an eye socket: nobody looks there from the side.
        """
        placed = self.pose.place(points)
        x, y = placed[:, 0], placed[:, 1]
        colours = sample_pixels(self.pictured, x, y).astype(np.float64)
        inside = sample_pixels(self.inside, x, y, border=0.0)
        nearest = sample_pixels(self.raster.depth, *self._shrunk(placed).T[:2], cv2.INTER_NEAREST, float("inf"))
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
