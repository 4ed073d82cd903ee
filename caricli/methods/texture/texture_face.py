"""A texture from the picture that a face was fitted to (portrait paper, section 3.2.3), right from every side."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.methods.texture.estimate_light import Light, estimate_light
from caricli.methods.texture.fill_unseen import fill_unseen, skin_weights
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
    light: Light that was taken out of it, or None.
    """

    image: np.ndarray
    seen: np.ndarray
    covered: np.ndarray
    light: Light | None


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
    normals = smooth_normals(head.vertices, head.faces)
    vertices = SurfacePoints(head.vertices, normals, head.mask(*CAVITIES).astype(np.float64))
    usual = view.look(vertices)
    light = None
    if not settings.keep_light:
        weights = skin_weights(head, usual.seen)
        light = estimate_light(usual.colours, normals, head.vertices, weights, -camera.rotation[2])
    shade = np.ones_like(normals) if light is None else light.shade(normals)
    points = texels.points(vertices, texels.corners)
    own_shade = texels.blend(shade, texels.corners)
    own = view.look(points)
    colours = own.unlit(own_shade)
    usual = usual.unlit(shade)
    hardly = usual
    mirror = head.annotation.mirror
    if mirror is not None:
        corners = mirror[texels.corners]
        other = view.look(texels.points(vertices, corners)).unlit(texels.blend(shade, corners))
        colours = colours.completed(other, settings.mirrored)
        usual = usual.completed(SeenColours(usual.colours[mirror], usual.seen[mirror]), settings.mirrored)
    trust = _trust(colours.seen, settings)
    filled = fill_unseen(head, usual)
    glimpse = np.clip(hardly.seen / settings.glimpse, 0, 1)[:, None]
    filled = texels.blend(glimpse * hardly.colours + (1 - glimpse) * filled, texels.corners)
    # What is full white may have been brighter.
    burnt = (own.colours >= settings.burnt) & (own_shade > 1)
    bare = np.where(burnt, np.maximum(colours.colours, filled), colours.colours)
    lit = own_shade * (trust * bare + (1 - trust) * filled)
    owner = texels.owner()
    bright = np.maximum(lit - 255, 0)
    sharp = (view.sharpen(lit - bright, _trust(own.seen, settings), points.places, owner) + bright) / own_shade
    seen = np.zeros(texels.covered.shape, np.float32)
    seen[texels.covered] = trust[:, 0]
    picture = np.round(np.clip(sharp, 0, 255)).astype(np.uint8)[owner]
    return FaceTexture(picture, seen, texels.covered, light)


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
        ends = np.arange(0, corners.size + 1, 3)
        return sp.csr_matrix((self.weights.ravel(), corners.ravel(), ends), (len(corners), len(values))) @ values

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
