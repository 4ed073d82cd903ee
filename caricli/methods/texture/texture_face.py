"""A texture from the picture that a face was fitted to (portrait paper, section 3.2.3), right from every side."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.texture.estimate_light import Light
from caricli.methods.texture.fill_unseen import fill_unseen, skin_colour
from caricli.methods.texture.folded_lids import folded_lids
from caricli.methods.texture.grow_grain import grow_grain
from caricli.methods.texture.light_on_head import light_on_head
from caricli.methods.texture.mouth_wall import mouth_wall, wall_colour
from caricli.methods.texture.picture_view import PictureView, SeenColours, Sight, SurfacePoints, likeness
from caricli.methods.texture.settings import TextureSettings
from caricli.methods.texture.texels import Texels
from caricli.render.smooth_normals import smooth_normals
from caricli.template.annotation import CAVITIES, EARS
from caricli.template.template import Template

_LIGHT_FROM_BEHIND = (0.5, 0.2)  # likeness to skin of what of an ear is lighter, from where on and with which it is


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
    sight: Sight,
    size: Texels | int | None = None,
    settings: TextureSettings = TextureSettings(),  # noqa: B008 (frozen)
    generator: np.random.Generator | None = None,
    like: FaceTexture | None = None,
) -> FaceTexture:
    """Paint a face with its picture where the picture shows it, and plausibly elsewhere.

    A texel takes the colour at its projection as far as it is seen, not at a grazing angle, and not where an outline
    may be; where it is not, that of its mirror image, if this is; the rest is filled over the surface from what is
    seen. What is hardly seen takes its own colour as far as this is like what fills it. Background never enters: it is
    replaced by diffused colours of the face first; nor do teeth enter the wall of the mouth, which is dark red, nor the
    lines of open eyes their lids, which a blink would draw out. Unless light is kept, a neck takes what is like the
    skin, where enough of it is seen: shadows of chins and collars stay out. Ears take what is no lighter than it: light
    from behind stays out. What a rendering blurs of this is then given back to the texels that are seen.

    head: Template with UVs, in the shape of the face. sight: Sight of it. size: texels, width and height, or the Texels
    of a head of the same topology; where there is none, the power of two, within limits, with which texels of what is
    seen are one to two pixels wide, by their median. settings: TextureSettings. generator: of the grain of the skin
    that is not seen (`grow_grain`); without one it is smooth. like: FaceTexture of the same face in the same light,
    which is taken out of this one too; None to find the light.
    Returns FaceTexture.
    """
    view = PictureView(head, sight, settings)
    texels = size if isinstance(size, Texels) else Texels(head, size or view.size())
    vertices = _vertices(head)
    usual = view.look(vertices)
    light = None if like is None else like.light
    if like is None and not settings.keep_light:
        light = light_on_head(head, usual, sight.camera)
    shade = np.ones_like(head.vertices) if light is None else light.shade_mesh(head.vertices, head.faces)
    usual = usual.unlit(shade)
    plain = None if settings.keep_light else _PlainSkin.of(head, usual, vertices, settings)
    points, own_shade = texels.points(vertices, shade)
    own = view.look(points)
    # What is full white may have been brighter.
    burnt = (own.colours >= settings.burnt) & (own_shade > 1)
    own = _counted(own.unlit(own_shade), points, plain)
    rest = (own.seen < settings.trust) | burnt.any(1)
    colours = own.colours.copy()
    trust = np.ones((len(colours), 1), np.float32)
    hardly = own.part(rest)
    some = texels.part(rest)
    both = hardly
    if head.annotation.mirror is not None:
        points_there, shade_there = some.mirrored(head.annotation.mirror).points(vertices, shade)
        there = _counted(view.look(points_there).unlit(shade_there), points_there, plain)
        both = both.completed(there, settings.mirrored * (1 - _trust(both.seen, settings)[:, 0]))
    trust[rest] = _trust(both.seen, settings)
    filled = _fill(head, _counted(usual, vertices, plain), hardly, some, settings)
    bare = np.where(burnt[rest], np.maximum(both.colours, filled), both.colours)
    colours[rest] = trust[rest] * bare + (1 - trust[rest]) * filled
    lit = own_shade * colours
    shown = np.minimum(lit, 255)
    sharp = view.sharpen(shown, _trust(own.seen, settings), points.places, texels.owner) + (lit - shown)
    sharp /= own_shade
    seen = np.zeros(texels.covered.shape, np.float32)
    seen[texels.covered] = trust[:, 0]
    if generator is not None:
        sharp = grow_grain(sharp[texels.owner], seen, texels.regions(head), generator)[texels.covered]
    picture = np.round(np.clip(sharp, 0, 255)).astype(np.uint8)[texels.owner]
    return FaceTexture(picture, seen, texels.covered, light)


def _vertices(head: Template) -> SurfacePoints:
    """The vertices of a head."""
    normals = smooth_normals(head.vertices, head.faces)
    parts = (CAVITIES, ("neck",), ("scalp",), EARS)
    pockets, neck, scalp, ears = (head.mask(*names).astype(np.float64) for names in parts)
    hidden = np.maximum(mouth_wall(head), folded_lids(head))
    return SurfacePoints(head.vertices, normals, pockets, hidden, neck, scalp, ears)


@dataclass(frozen=True, eq=False)
class _PlainSkin:
    """What of neck and ears is skin like that of the face. colour: (3,) that it has. other: as in TextureSettings.
    neck: whether enough of the neck is seen for any to count."""

    colour: np.ndarray
    other: float
    neck: bool = True

    @staticmethod
    def of(head: Template, usual: SeenColours, vertices: SurfacePoints, settings: TextureSettings) -> "_PlainSkin":
        """Of a head whose vertices are seen so, without light."""
        plain = _PlainSkin(skin_colour(head, usual), settings.other)
        rows = head.mask("neck")
        neck = bool(rows.any()) and float(plain.counted(usual, vertices).seen[rows].mean()) >= settings.neck
        return replace(plain, neck=neck)

    def counted(self, seen: SeenColours, points: SurfacePoints) -> SeenColours:
        """What is seen of points without light, of neck and ears what counts."""
        shares = seen.seen.copy()
        neck, rows = _among(points.neck, shares)
        like = likeness(seen.colours[rows], self.colour, self.other) if self.neck else 0.0
        shares[rows] *= 1 - neck * (1 - like)
        ears, rows = _among(points.ears, shares)
        lighter = np.maximum(seen.colours[rows], self.colour)
        shares[rows] *= 1 - ears * smooth_step(likeness(lighter, self.colour, self.other), *_LIGHT_FROM_BEHIND)
        return SeenColours(seen.colours, shares)


def _among(part: np.ndarray | float, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far points are in a part, of all or (N,), of those that are: (K,), and which they are. shares: (N,)."""
    inside = np.broadcast_to(part, shares.shape)
    rows = np.flatnonzero(inside)
    return inside[rows], rows


def _counted(seen: SeenColours, points: SurfacePoints, plain: _PlainSkin | None) -> SeenColours:
    """What is seen of points that counts: all where light is kept, and shadows with it."""
    return seen if plain is None else plain.counted(seen, points)


def _fill(
    head: Template, vertices: SeenColours, hardly: SeenColours, texels: Texels, settings: TextureSettings
) -> np.ndarray:
    """(N, 3) colours of texels that are hardly seen, themselves and by vertices, without light."""
    mirror = head.annotation.mirror
    usual = vertices
    if mirror is not None:
        usual = usual.completed(SeenColours(usual.colours[mirror], usual.seen[mirror]), settings.mirrored)
    continued = fill_unseen(head, usual)
    trust = _trust(vertices.seen, settings)[:, 0]
    glimpse = np.clip(vertices.seen / settings.glimpse, 0, 1)
    # What only a glimpse shows may be an outline, which does not go on over the side.
    own = (trust + (1 - trust) * glimpse * likeness(vertices.colours, continued, settings.other))[:, None]
    wall = mouth_wall(head)[:, None]
    bare = own * vertices.colours + (1 - own) * continued
    filled = texels.mix @ ((1 - wall) * bare + wall * wall_colour(vertices.colours)).astype(np.float32)
    like = likeness(hardly.colours, filled, settings.other) * np.clip(hardly.seen / settings.glimpse, 0, 1)
    return like[:, None] * hardly.colours + (1 - like[:, None]) * filled


def _trust(seen: np.ndarray, settings: TextureSettings) -> np.ndarray:
    """(N, 1) from 0 to 1, how much of the picture texels take that are seen as far as (N,)."""
    return smooth_step(seen, 0, settings.trust)[:, None]
