"""A texture from the picture that a face was fitted to (portrait paper, section 3.2.3), right from every side."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.texture.picture_view import PictureView, SeenColours, SurfacePoints
from caricli.methods.texture.settings import TextureSettings
from caricli.render.smooth_normals import smooth_normals
from caricli.render.uv_map import pad_texture, uv_map
from caricli.structures import Camera
from caricli.template.annotation import CAVITIES
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class FaceTexture:
    """A texture and where it comes from.

    image: (S, S, 3) uint8 sRGB, the top row first.
    seen: (S, S) float32, from 0 where a texel is made up to 1 where the picture shows it.
    covered: (S, S) bool, texels of the surface.
    """

    image: np.ndarray
    seen: np.ndarray
    covered: np.ndarray


def texture_face(
    head: Template,
    camera: Camera,
    image: np.ndarray,
    mask: np.ndarray,
    size: int | None = None,
    settings: TextureSettings = TextureSettings(),  # noqa: B008 (frozen)
) -> FaceTexture:
    """Paint a face with its picture where the picture shows it, and plausibly elsewhere.

    A texel takes the colour at its projection as far as it is seen, not at a grazing angle, and not near the border of
    the mask; where it is not, that of its mirror image, if this is; the rest is filled by diffusion over the surface
    from what is seen. Background never enters: it is replaced by diffused colours of the face first. What a rendering
    blurs of this is then given back to the texels that are seen.

    head: Template with UVs, in the shape of the face. camera: Camera of the picture. image: (H, W, 3) uint8. mask:
    (H, W) bool, the head. size: texels, width and height; where there is none, the power of two, within limits, with
    which texels of what is seen are one to two pixels wide, by their median. settings: TextureSettings.
    Returns FaceTexture.
    """
    view = PictureView(head, camera, image, mask, settings)
    texels = _Texels(head, size or view.size())
    vertices = SurfacePoints(
        head.vertices, smooth_normals(head.vertices, head.faces), head.mask(*CAVITIES).astype(np.float64)
    )
    points = texels.points(vertices, texels.corners)
    own = view.look(points)
    colours = own
    usual = view.look(vertices)
    mirror = head.annotation.mirror
    if mirror is not None:
        colours = own.completed(view.look(texels.points(vertices, mirror[texels.corners])), settings.mirrored)
        usual = usual.completed(SeenColours(usual.colours[mirror], usual.seen[mirror]), settings.mirrored)
    trust = _trust(colours.seen, settings)
    filled = texels.blend(_spread(usual, head.faces, settings), texels.corners)
    painted = trust * colours.colours + (1 - trust) * filled
    owner = texels.owner()
    sharp = view.sharpen(painted, _trust(own.seen, settings), points.places, owner)
    seen = np.zeros(texels.covered.shape, np.float32)
    seen[texels.covered] = trust[:, 0]
    return FaceTexture(np.round(sharp).astype(np.uint8)[owner], seen, texels.covered)


class _Texels:
    """The N texels that show a surface: corners (N, 3) of their triangles, and the weights (N, 3) of these."""

    def __init__(self, head: Template, size: int) -> None:
        """size: texels, width and height of the texture."""
        face, weights = uv_map(head, size)
        self.covered = face >= 0
        self.corners = head.faces[face[self.covered]]
        self.weights = weights[self.covered].astype(np.float64)

    def blend(self, values: np.ndarray, corners: np.ndarray) -> np.ndarray:
        """(N, C) values of vertices (V, C) between the corners (N, 3)."""
        return np.einsum("nk,nkc->nc", self.weights, values[corners])

    def points(self, vertices: SurfacePoints, corners: np.ndarray) -> SurfacePoints:
        """The same between the corners (N, 3) for what is known of the vertices."""
        pockets = (self.weights * vertices.pockets[corners]).sum(1)
        return SurfacePoints(self.blend(vertices.places, corners), self.blend(vertices.normals, corners), pockets)

    def owner(self) -> np.ndarray:
        """(S, S) the texel, from 0 to N - 1, that each place of the texture shows; beyond the islands the nearest."""
        ids = np.zeros(self.covered.shape, int)
        ids[self.covered] = np.arange(len(self.corners))
        return pad_texture(ids, self.covered)


def _trust(seen: np.ndarray, settings: TextureSettings) -> np.ndarray:
    """(N, 1) from 0 to 1, how much of the picture texels take that are seen as far as (N,)."""
    trust = np.clip(seen / settings.trust, 0, 1)[:, None]
    return trust * trust * (3 - 2 * trust)


def _spread(vertices: SeenColours, faces: np.ndarray, settings: TextureSettings) -> np.ndarray:
    """(V, 3) colours of vertices, those that are not seen the smoothest continuation of the others."""
    adjacency, _ = vertex_neighbours(faces, len(vertices.colours))
    laplacian = sp.diags(np.asarray(adjacency.sum(1)).ravel()) - adjacency
    hold = settings.hold * vertices.seen**2
    usual = np.average(vertices.colours, axis=0, weights=vertices.seen + 1e-9)
    right = hold[:, None] * vertices.colours + settings.faint * usual
    return Cholesky(laplacian + sp.diags(hold + settings.faint)).solve(right)
