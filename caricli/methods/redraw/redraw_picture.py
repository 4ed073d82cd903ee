"""A picture with another expression of the head in it (expressions paper, section 4.4 and figure 7)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.redraw.changed_paint import ChangedPaint, changed_paint
from caricli.methods.redraw.fill_behind import fill_behind
from caricli.methods.redraw.moved_head import MovedHead
from caricli.methods.redraw.original import PAPER, Original
from caricli.methods.redraw.spread_colours import box_around, spread_colours
from caricli.methods.texture.picture_view import likeness
from caricli.methods.texture.settings import TextureSettings
from caricli.render.pixels.sample_texture import sample_texture
from caricli.structures import Material
from caricli.structures.materials import FINISHES
from caricli.structures.texture_change import TextureChange

_OPAQUE = 255


def redraw_picture(original: Original, vertices: np.ndarray, change: TextureChange | None = None) -> np.ndarray:
    """Draw a picture again with the head in another shape.

    Where the old picture showed a point of the head, the point keeps its colour, as much brighter or darker as it is
    turned to the light that is estimated; elsewhere it takes the texture's, in that light, with what the old picture
    differs from it around. Both take the change of paint. What is in the mouth stretches with the lips or is drawn
    anew.

    original: Original. vertices: (W, 3) metres, of its rig. change: what the expression does to the paint of the face,
    in its chart, or None for nothing.
    Returns (H, W, 3) uint8, which is the old picture wherever nothing moved or changed.
    """
    moved = _Moved.of(original, vertices, change)
    image = original.picture.copy()
    if moved.anew.max() > 0:
        drawn = moved.draw(original.picture, _painted(original, moved.head, moved.changed))
        _lay(image, drawn, moved)
    return image


def redraw_layer(original: Original, vertices: np.ndarray, change: TextureChange | None = None) -> np.ndarray:
    """Draw a picture that is transparent in places again, as ``redraw_picture`` does.

    What the old picture showed is as opaque as it was there, what is drawn anew is opaque.

    original: Original with a layer. vertices, change: as in ``redraw_picture``.
    Returns (H, W, 4) uint8, which is the old layer wherever nothing moved or changed.
    """
    assert original.layer is not None
    moved = _Moved.of(original, vertices, change)
    image = original.layer.copy()
    if moved.anew.max() > 0:
        head = moved.head
        drawn = moved.draw(original.picture, _painted(original, head, moved.changed))
        opaque = np.repeat(original.layer[..., 3:], 3, axis=2)
        carried = head.picture(head.source, opaque)
        alpha = moved.draw(opaque, _OPAQUE + head.shown[..., None] * (carried - _OPAQUE))
        colours = PAPER + (drawn - PAPER) * _OPAQUE / np.maximum(alpha, 1)
        # Nothing tells the colours of what is not seen.
        clear = original.window.cut(original.layer)[..., :3]
        colours = np.where(np.rint(alpha) > 0, colours, clear)
        _lay(image, np.dstack([colours, alpha[..., :1]]), moved)
    return image


@dataclass(frozen=True, eq=False)
class _Moved:
    """A head in another shape, and what of its picture that changes.

    head: MovedHead. changed: ChangedPaint, or None. anew: (H, W) float32 from 0 to 1, how far samples are drawn anew.
    """

    head: MovedHead
    changed: ChangedPaint | None
    anew: np.ndarray

    @staticmethod
    def of(original: Original, vertices: np.ndarray, change: TextureChange | None) -> "_Moved":
        """Arguments as of ``redraw_picture``."""
        settings = original.settings
        head = MovedHead(original, vertices)
        changed = None if change is None else changed_paint(head, change)
        anew = smooth_step(head.motion, settings.still, settings.moved)
        if changed is not None:
            anew = np.maximum(anew, smooth_step(changed.strength, *settings.changed))
        return _Moved(head, changed, anew)

    @cached_property
    def share(self) -> np.ndarray:
        """(h, w, 1) float32 from 0 to 1: how far pixels of the window are drawn anew."""
        return self.head.original.window.means(self.anew)[..., None]

    def draw(self, picture: np.ndarray, painted: np.ndarray) -> np.ndarray:
        """(h, w, 3) float32: the window of a picture (H, W, 3) with the head in other colours, samples (H, W, 3)."""
        window = self.head.original.window
        new = _composed(self.head, picture, painted)
        return window.means(new * self.anew[..., None]) + (1 - self.share) * window.cut(picture)


def _lay(image: np.ndarray, drawn: np.ndarray, moved: _Moved) -> None:
    """Put what is drawn (h, w, C) into the window of an image (H, W, C), as far as anything is drawn anew."""
    pixels = moved.share[..., 0] > 0
    moved.head.original.window.cut(image)[pixels] = np.rint(np.clip(drawn[pixels], 0, 255))


def _painted(original: Original, head: MovedHead, changed: ChangedPaint | None) -> np.ndarray:
    """(H, W, 3) float32 colours of the head: of the old picture where it showed this, else of what the head wears."""
    old = head.picture(head.source, original.picture) * head.light_ratio
    materials = _materials(original, head)
    lit = _worn(original, head, materials) * head.shade
    if original.rows is not None:
        # Teeth that are drawn need no others beside them.
        teeth = np.isin(materials, (Material.TEETH, Material.GUMS))
        beside = (head.view.inside & ~teeth).astype(np.float32)
        near = box_around(teeth)
        lit[near] = np.where(teeth[near][..., None], spread_colours(lit[near], beside[near]), lit[near])
    if changed is not None:
        old = changed.paint(old)
        lit = changed.paint(lit)
    seen = head.shown
    eyes = materials == Material.EYE
    # In a mouth a colour says nothing of what is beside it.
    apart = old - lit
    colours = np.where(head.view.inside[..., None], lit + seen[..., None] * apart, lit)
    for part in (eyes, head.view.covered & ~eyes & ~head.view.inside):
        # Beside the part nothing counts.
        near = box_around(part)
        told = head.told[near] if part is not eyes else seen[near]
        own = seen[near][..., None]
        more = own * apart[near] + (1 - own) * spread_colours(apart[near], part[near] * told)
        colours[near][part[near]] += more[part[near]]
    _draw_seam(head, colours)
    return _closed(head, old, np.clip(colours, 0, 255))


def _draw_seam(head: MovedHead, colours: np.ndarray) -> None:
    """Give a mouth that has closed to a line, in colours (H, W, 3), that of the lips beside it in their shade."""
    near = box_around(head.seam > 0)
    lips = (head.view.covered & ~head.view.inside)[near].astype(np.float32)
    line = head.original.settings.seam * spread_colours(colours[near], lips)
    colours[near] += head.seam[near][..., None] * (line - colours[near])


def _closed(head: MovedHead, old: np.ndarray, painted: np.ndarray) -> np.ndarray:
    """Painted colours (H, W, 3) with skin of the lids' surroundings, old colours (H, W, 3), and lashes on lids that
    have closed: an eye that is drawn large is on them in the texture, too.
    """
    near = box_around(head.lids > 0)
    lids = head.between[near] * head.lids[near]
    if not lids.any():
        return painted
    skin = head.shown[near] * head.lids[near]
    old, new, beside = old[near], painted[near], head.beside_lids[near]
    usual = np.median(old[skin > 0.9], axis=0) if (skin > 0.9).any() else new[lids > 0].mean(0)
    like = likeness(old.reshape(-1, 3), usual, TextureSettings.other).reshape(skin.shape).astype(np.float32)
    plain = spread_colours(old.astype(np.float32), skin * like**2 * (1 - beside))
    lids = np.maximum(lids, beside * (1 - like**2))
    new = new + lids[..., None] * (plain - new)
    dark = np.array(FINISHES[Material.LASHES].colour, np.float32)
    painted[near] = new + head.lashes[near][..., None] * (dark - new)
    return painted


def _composed(head: MovedHead, picture: np.ndarray, painted: np.ndarray) -> np.ndarray:
    """(H, W, 3) float32: the painted head before what is behind it in a picture, and behind what is before it."""
    original = head.original
    old = original.window.sampled(picture).astype(np.float32)
    behind = fill_behind(head, picture)
    back = behind + head.solid[..., None] * (painted - behind)
    # The strip beside an outline goes with it.
    strip = head.strip * head.look(original.head, head.strip_source)
    strip = strip * (1 - head.look(original.hidden, head.strip_source))
    new = back + strip[..., None] * (head.picture(head.strip_source, picture) - back)
    nearer = smooth_step((original.depth - head.view.depth) / head.view.jump, 0.5, 1.5)
    before = np.maximum(original.held, original.laid * (1 - nearer))[..., None]
    return new + before * (old - new)


def _materials(original: Original, head: MovedHead) -> np.ndarray:
    """(H, W) int: the Material of every sample, -1 beside the head."""
    materials = original.rig.triangle_materials[original.kept]
    return np.where(head.view.covered, materials[head.view.face], -1)


def _worn(original: Original, head: MovedHead, materials: np.ndarray) -> np.ndarray:
    """(H, W, 3) float32 colours of what a head wears at samples of some materials (H, W), without light."""
    mesh = original.rig.mesh
    colours = np.zeros((*materials.shape, 3), np.float32)
    for material in np.unique(materials[head.view.covered]):
        own = materials == material
        picture = original.rig.pictures.of(material)
        if picture is None or mesh.uvs is None:
            colours[own] = original.rig.pictures.finish(material).colour
        else:
            corners = mesh.uvs[mesh.uv_faces[original.kept][head.view.face[own]]]
            colours[own] = sample_texture(picture, np.einsum("nk,nkc->nc", head.view.weights[own], corners))
    return colours
