"""What a picture shows of points of a surface."""

from dataclasses import dataclass

import cv2
import numpy as np
import scipy.sparse as sp

from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.texture.settings import TextureSettings
from caricli.render.pixels.diffuse_background import diffuse_background
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.sample_texture import sample_pixels, texture_matrix
from caricli.render.visibility.nearest_pixel import nearest_pixel
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Mesh

_BESIDE = 4.0  # widths of the band inside a border: so far from what was left out, what is unlike the rest counts less
_AROUND = 6.0  # the same, as far as the rest is


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points of a surface.

    places: (N, 3) metres. normals: (N, 3) of any length. pockets: (N,) from 0 to 1, how far they are in the mouth or an
    eye socket: nobody looks there from the side. hidden: (N,) from 0 to 1, how far they are not what the picture shows
    there, or that for all. neck, scalp, ears: the same of how far they are on the neck, on scalp or hair, on an ear.
    """

    places: np.ndarray
    normals: np.ndarray
    pockets: np.ndarray
    hidden: np.ndarray | float = 0.0
    neck: np.ndarray | float = 0.0
    scalp: np.ndarray | float = 0.0
    ears: np.ndarray | float = 0.0


@dataclass(frozen=True, eq=False)
class SeenColours:
    """What a picture shows of points.

    colours: (N, 3) sRGB, 0 to 255. seen: (N,) from 0 to 1, how far the points are seen.
    """

    colours: np.ndarray
    seen: np.ndarray

    def unlit(self, shade: np.ndarray) -> "SeenColours":
        """The same without light, which made them shade (N, 3) times as bright."""
        return SeenColours(self.colours / shade, self.seen)

    def part(self, rows: np.ndarray) -> "SeenColours":
        """Of the points those of rows (N,) bool."""
        return SeenColours(self.colours[rows], self.seen[rows])

    def completed(self, other: "SeenColours", weight: float | np.ndarray) -> "SeenColours":
        """With those of the other side where these are hardly seen. weight: of the other side, of all or (N,)."""
        share = self.seen / np.maximum(self.seen + weight * other.seen, 1e-9)
        colours = share[..., None] * self.colours + (1 - share[..., None]) * other.colours
        return SeenColours(colours, np.maximum(self.seen, other.seen * (1 - share)))


@dataclass(frozen=True, eq=False)
class Sight:
    """What a camera saw.

    camera: Camera. image: (H, W, 3) uint8. mask: (H, W) bool, what is to be painted in it. whole: (H, W) bool, that
    with what is before it and was left out, as hair; None for nothing. Only the border of the whole is an outline.
    beside: (H, W) bool, what of it was left out so that paint fades out beside it; None for nothing. It ends sharply at
    lips and lids.
    """

    camera: Camera
    image: np.ndarray
    mask: np.ndarray
    whole: np.ndarray | None = None
    beside: np.ndarray | None = None


class PictureView:
    """A head in a picture: colours without background, depth, and how far a pixel is one of the head."""

    def __init__(self, head: Mesh, sight: Sight, settings: TextureSettings) -> None:
        """head: Mesh with UVs. sight: Sight of it."""
        camera = sight.camera
        mask = sight.mask
        self.camera = camera
        self.settings = settings
        self.height = head.height
        assert head.uvs is not None
        self.corners = head.uvs[head.uv_faces]
        self.pictured = diffuse_background(sight.image, mask)
        self.inside = self._inside(mask, mask if sight.whole is None else sight.whole)
        if sight.beside is not None:
            self.inside *= self._fading(mask, sight.beside)
        rows, columns = mask.shape
        placed = camera.place(head.vertices)
        self.raster = rasterise(placed, head.faces, columns, rows)
        face = self.raster.face
        self.pixels = mask & (face >= 0) & (triangle_normals(placed, head.faces)[face, 2] < 0)
        flat = placed[head.faces]
        self.areas = np.abs(np.linalg.det(flat[:, 1:, :2] - flat[:, :1, :2]))

    def size(self) -> int:
        """Texels, width and height, none wider than two pixels, by the median over what is seen."""
        smallest = self.settings.smallest
        face = self.raster.face[self.pixels]
        spans = np.abs(np.linalg.det(self.corners[:, 1:] - self.corners[:, :1]))[face]
        texels = np.median(np.sqrt(self.areas[face] / np.maximum(spans, 1e-12))) if len(face) else smallest
        return int(np.clip(2 ** int(np.log2(max(texels, 1))), smallest, self.settings.largest))

    def look(self, points: SurfacePoints) -> SeenColours:
        """The colours of points, and how far they are seen."""
        settings = self.settings
        placed = self._place(points.places)
        x = placed[:, 0]
        y = placed[:, 1]
        colours = sample_pixels(self.pictured, x, y).astype(placed.dtype)
        inside = sample_pixels(self.inside, x, y, border=0.0)
        behind = placed[:, 2] - sample_pixels(self.raster.depth, x, y, cv2.INTER_NEAREST, float("inf"))
        lengths = np.sqrt(np.einsum("nk,nk->n", points.normals, points.normals))
        cosine = -(points.normals @ self.camera.rotation[2].astype(placed.dtype)) / np.maximum(lengths, 1e-9)
        # A surface at an angle is behind itself within the width of a pixel.
        allowed = max(settings.behind * self.camera.scale * self.height, 1.0) / np.clip(cosine, 0.2, 1)
        least = settings.grazing + points.scalp * (settings.grazing_hair - settings.grazing)
        most = settings.facing + points.scalp * (settings.facing_hair - settings.facing)
        facing = np.clip((cosine - least) / (most - least), 0, 1) ** 2
        shown = np.maximum(facing, points.pockets) * (1 - points.hidden)
        return SeenColours(colours, shown * inside * (behind < allowed))

    def sharpen(self, colours: np.ndarray, trust: np.ndarray, places: np.ndarray, owner: np.ndarray) -> np.ndarray:
        """Colours (N, 3) of texels with which a rendering comes nearer to the picture.

        A rendering mixes four texels at every pixel. What then differs from the picture is given back to them, as far
        as each is seen, and to texels between pixels as what it is there; none leaves the colours that the picture has
        next to it.

        colours: (N, 3) from 0 to 255. trust: (N, 1) from 0 to 1. places: (N, 3) metres, of the texels. owner: (S, S)
        the texel that each place of the texture shows.
        """
        face = self.raster.face[self.pixels]
        weights = self.raster.barycentric[self.pixels]
        lookup = texture_matrix(owner, len(colours), np.einsum("nk,nkc->nc", weights, self.corners[face]))
        missing = np.zeros(self.pictured.shape, np.float32)
        # Only once as far as it is seen: in rounds, what is hardly seen would take on the picture all the same.
        missing[self.pixels] = (lookup @ trust) * (self.pictured[self.pixels] - lookup @ colours)
        sharper = colours.copy()
        seen = trust[:, 0] > 0
        if not seen.any():
            return sharper
        lookup = _columns(lookup, seen)
        back = lookup.T.tocsr()
        alone = self.settings.alone
        total = back @ np.ones((len(face), 1), np.float32) + alone
        x, y, _ = self._place(places[seen]).T
        current = before = colours[seen]
        least, most = self._range(x, y, current)
        for number in range(self.settings.rounds):
            if number:
                missing[self.pixels] -= lookup @ (current - before)
            before = current
            share = (back @ missing[self.pixels] + alone * sample_pixels(missing, x, y)) / total
            current = np.clip(current + trust[seen] * share, least, most)
        sharper[seen] = current
        return sharper

    def _inside(self, mask: np.ndarray, whole: np.ndarray) -> np.ndarray:
        """(H, W) float32 from 0 to 1, how far pixels show what the mask (H, W) bool is of.

        Near the border of the whole (H, W) a picture may show the outline of the drawing, or what is behind: there
        counts what looks as that which is nearest to it and farther inside.
        """
        reach = self._band
        depth = cv2.distanceTransform(np.pad(whole, 1).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
        inside = (mask * np.clip(depth / reach - 0.5, 0, 1)).astype(np.float32)
        deep = mask & (inside == 1)
        rim = mask & ~deep
        if deep.any() and rim.any():
            row, column = nearest_pixel(deep)
            usual = _blur(self.pictured, deep, reach)[row[rim], column[rim]]
            like = likeness(self.pictured[rim], usual, self.settings.other) ** 2
            # The outermost pixel is a mixture.
            inside[rim] = np.maximum(inside[rim], np.clip(depth[rim] - 1, 0, 1) * like)
        return inside

    def _fading(self, mask: np.ndarray, beside: np.ndarray) -> np.ndarray:
        """(H, W) from 0 to 1, how far paint, (H, W) bool, counts beside what was left out of it, (H, W) bool.

        It ends softly, and what is unlike the colours around, as a fold that goes on there, sooner.
        """
        away = exact_distance_to(beside) / self._band
        share: np.ndarray = np.minimum(away, 1)
        near = mask & (away < _BESIDE)
        usual = _blur(self.pictured, mask, _AROUND * self._band)[near]
        like = likeness(self.pictured[near], usual, self.settings.other) ** 2
        share[near] *= like + (1 - like) * away[near] / _BESIDE
        return share

    @property
    def _band(self) -> float:
        """Pixels, width of the band inside a border that hardly counts."""
        return max(self.settings.edge * self.camera.scale * self.height, 1.0)

    def _range(self, x: np.ndarray, y: np.ndarray, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest colours (N, 3) that texels may take: their own, and those of the pixels around."""
        square = np.ones((3, 3), np.uint8)
        darkest = sample_pixels(cv2.erode(self.pictured, square), x, y, cv2.INTER_NEAREST)
        brightest = sample_pixels(cv2.dilate(self.pictured, square), x, y, cv2.INTER_NEAREST)
        return np.minimum(darkest, colours), np.maximum(brightest, colours)

    def _place(self, points: np.ndarray) -> np.ndarray:
        """Pixels and depth (N, 3) of points (N, 3), as exact as these are."""
        camera = self.camera
        matrix = np.column_stack([camera.scale * camera.rotation, [*camera.translation, 0]])
        if not len(points):
            return np.zeros_like(points)
        # Of two threads that multiply matrices one waits for the other.
        return cv2.transform(np.ascontiguousarray(points)[None], matrix)[0]


def _columns(matrix: sp.csr_matrix, kept: np.ndarray) -> sp.csr_matrix:
    """The columns of a matrix (N, M) that are kept, (M,) bool, quicker than by their index."""
    number = np.cumsum(kept) - 1
    data = np.where(kept[matrix.indices], matrix.data, 0)
    indices = np.maximum(number, 0).astype(matrix.indices.dtype)[matrix.indices]
    return sp.csr_matrix((data, indices, matrix.indptr), (matrix.shape[0], int(kept.sum())))


def likeness(colours: np.ndarray, usual: np.ndarray, other: float) -> np.ndarray:
    """(N,) from 0 to 1, how far colours (N, 3) are those of what has the usual ones (N, 3), 0 to 255.

    other: their difference, of full scale, that makes it one half.
    """
    return 1 / (1 + ((colours - usual) ** 2).mean(1) / (255 * other) ** 2)


def _blur(image: np.ndarray, mask: np.ndarray, radius: float) -> np.ndarray:
    """(H, W, 3) means of what of a picture is in a mask (H, W) bool, around its pixels. radius: pixels."""
    side = 2 * int(radius) + 1
    share = cv2.blur(mask.astype(np.float32), (side, side))
    return cv2.blur(image * mask[..., None].astype(np.float32), (side, side)) / np.maximum(share, 1e-6)[..., None]
