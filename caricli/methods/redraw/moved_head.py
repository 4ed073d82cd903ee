"""A head that has moved in its picture: where the old picture showed each point of it."""

from functools import cached_property

import cv2
import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.redraw.openings import drawn_anew, seams
from caricli.methods.redraw.original import Original, blurred
from caricli.methods.redraw.spread_colours import box_around, spread_colours
from caricli.methods.redraw.view import Window
from caricli.methods.texture.estimate_light import GAMMA
from caricli.render.sky import DIRECTIONS, light_received, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Material

_NEAR = 0.012  # of the head's height: what is so little behind the surface is on it
_FINE = 0.8  # pixels, softness of lashes
_THICK = 2.2
_BITS = 4  # of a sample's fraction
_LEVEL = 1e-3
_HALF = 0.5


class MovedHead:
    """Another shape of the head of an Original, sample by sample.

    view: View of it. source: (H, W, 2) float32 pixels of the old picture where what the samples show now was then,
    their own beside the head; what is in the mouth follows teeth and lips, not point by point, because drawn teeth are
    seldom where the head's are. shift: (H, W, 2) of the source from the samples.
    """

    def __init__(self, original: Original, vertices: np.ndarray) -> None:
        """vertices: (W, 3) metres."""
        self.original = original
        self.vertices = vertices
        self.view = original.see(original.depiction.camera.place(vertices.astype(float)))
        places = original.window.places
        self._before = self.view.carried(original.placed)
        shift = np.where(self.view.covered[..., None], self._before[..., :2] - places, 0)
        mouth = box_around(self.view.inside)
        inside = self.view.inside[mouth]
        lips = (self.view.covered[mouth] & ~inside).astype(np.float32)
        within, kept = self._in_mouth(spread_colours(shift[mouth], lips), mouth)
        shift[mouth] = np.where(inside[..., None], within, shift[mouth])
        self.shift = shift.astype(np.float32, copy=False)
        self._kept = np.ones(shift.shape[:2], np.float32)
        self._kept[mouth] = kept * (1 - self.seam[mouth])
        self.source = places + self.shift

    def _in_mouth(self, spread: np.ndarray, mouth: tuple[slice, slice]) -> tuple[np.ndarray, np.ndarray]:
        """Shifts (h, w, 2) of what is in the mouth, and how far (h, w), from 0 to 1, the old picture shows it.

        Across the face it follows the lips, along it the teeth: upper ones go with the skull, lower ones with the jaw,
        and between them the mouth opens. spread: (h, w, 2) shifts of the lips, carried on between them. mouth: rows and
        columns, h and w of them.
        """
        rows = self.original.rows
        if rows is None:
            return spread, np.ones(spread.shape[:2], np.float32)
        right = self.original.depiction.camera.rotation[:2, 0]
        across = np.outer(right, right) / (right @ right)
        open_before = (self.original.view.inside | self.original.mouth).astype(np.float32)
        parts = []
        for row, part in ((rows.upper, 1 - rows.below), (rows.lower, rows.below)):
            moved = (self.view.placed - self.original.placed)[row, :2].mean(0)
            shift = (spread @ across - moved @ (np.eye(2) - across)).astype(np.float32)
            parts.append((shift, self.look(open_before * part, self.original.window.places[mouth] + shift)))
        (above, kept_above), (below, kept_below) = parts
        lower = kept_below > kept_above
        return np.where(lower[..., None], below, above), np.where(lower, kept_below, kept_above)

    @cached_property
    def seam(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples are in a mouth whose drawn teeth have closed to a line."""
        if self.original.rows is None:
            return np.zeros(self.view.face.shape, np.float32)
        return seams(self.original, self.view)

    @cached_property
    def shown(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far the old picture shows what the samples show now."""
        original = self.original
        hidden = self.look(original.hidden)
        stained = self.look(self.stain) * np.isinf(self.view.away)
        beyond = self.look(original.beside) * (1 - self._edge)
        shown = self._bared * (1 - hidden) * (1 - stained) * (1 - self.between) * (1 - beyond)
        return np.where(self.view.inside, self._kept * (1 - self._anew), shown).astype(np.float32)

    @cached_property
    def told(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far what is shown tells the colours of what is around it and is not.

        Slivers between what was hidden, and what is beside the border, are mixtures and drawn lines.
        """
        original = self.original
        across = 4 * int(np.ceil(original.settings.line * original.size * original.window.fine)) + 1
        # A square is many times as quick as a disc.
        broad = cv2.morphologyEx((self.shown > _HALF).astype(np.uint8), cv2.MORPH_OPEN, np.ones((across, across)))
        told: np.ndarray = self.shown * broad * (1 - self.look(original.beside))
        return told

    @cached_property
    def solid(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show the head; no mesh ends just where a drawing does.

        What has gone farther in than it was is head, whatever the drawing showed there.
        """
        original = self.original
        inwards = self.view.inwards - self.look(original.view.inwards)
        reach = original.settings.line * original.size * original.window.fine
        return self.view.covered * (1 - self.look(original.apart) * smooth_step(inwards, 2 * reach, reach))

    @cached_property
    def _edge(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how near samples on the head are to its border before what is behind it."""
        reach = self.original.settings.band * self.original.size * self.original.window.fine
        return smooth_step(self.view.inwards, reach, reach / 3) * self.view.covered

    @cached_property
    def between(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far the old picture shows, where skin was, what is between lips or lids."""
        return self._turned_to_skin * self.look(self.original.openings)

    @cached_property
    def beside_lids(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples are skin of closed lids where more of an eye may be drawn."""
        return self._turned_to_skin * self.lids * self.look(self.original.rims)

    @cached_property
    def _turned_to_skin(self) -> np.ndarray:
        eyes = self.view.carried(np.sum([*self.original.eyes.values()], axis=0)[:, None])[..., 0] > 0.5
        return self._anew * (self.view.covered & ~self.view.inside & ~eyes)

    @cached_property
    def lids(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show lids and what is around them."""
        lids = np.any([*self.original.lids.values()], axis=0)
        return self.view.carried(lids.astype(float)[:, None])[..., 0]

    @cached_property
    def lashes(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show lashes of an eye that has closed."""
        original = self.original
        faces = original.rig.faces[original.rig.triangle_materials == Material.LASHES]
        if not len(faces):
            return np.zeros(self.view.face.shape, np.float32)
        hairs = original.window.samples(self.view.placed)[faces].astype(np.float32)
        drawn = np.zeros(self.view.face.shape, np.uint8)
        width, height = original.window.size
        columns, rows = np.rint(hairs[..., :2].mean(1)).astype(int).T
        skin = self.view.depth[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        before = hairs[..., 2].mean(1) < skin + _NEAR * original.size
        # Hairs are finer than samples, which would show dots of them: they are drawn as pale as they are thin.
        hairs = hairs[before, :, :2]
        sides = np.linalg.norm(hairs - np.roll(hairs, 1, axis=1), axis=2).max(1)
        dark = np.clip(np.abs(_twice_areas(hairs)) / np.maximum(sides, _LEVEL), 0, 1)
        for k in np.argsort(dark):
            corners = np.rint(hairs[k] * 2**_BITS).astype(np.int32)
            cv2.fillConvexPoly(drawn, corners, round(255 * float(dark[k])), cv2.LINE_AA, _BITS)
        line = np.minimum(_THICK * blurred(drawn.astype(np.float32) / 255, _FINE * original.window.fine), 1)
        return line * self._anew * (self.lids > 0)

    @cached_property
    def _anew(self) -> np.ndarray:
        return self.view.carried(drawn_anew(self.original, self.view)[:, None])[..., 0]

    @cached_property
    def _bared(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples were before all others, and not turned away."""
        original = self.original
        settings = original.settings
        behind = self._before[..., 2] - self.look(original.nearest)
        new = np.abs(_areas(self.view.placed, original.faces))
        # Of what was turned away in the old picture there is no more than a sliver.
        share = _areas(original.placed, original.faces) / np.maximum(new, _LEVEL)
        share = np.clip((share - settings.narrow) / (settings.wide - settings.narrow), 0, 1)
        corners = original.faces.ravel()
        counts = np.bincount(corners, minlength=len(self.vertices))
        share = np.bincount(corners, np.repeat(share, 3), len(self.vertices)) / np.maximum(counts, 1)
        turned = smooth_step(self.view.carried(share[:, None])[..., 0], 0, 1)
        near = _NEAR * original.size
        return smooth_step(behind, 2 * near, near) * turned * self.view.covered

    @cached_property
    def _gone(self) -> np.ndarray:
        """(H, W) float32: by how many pixels what the old picture shows at the samples has moved."""
        return _lengths(self.original.view.carried(self.view.placed[:, :2] - self.original.placed[:, :2]))

    @cached_property
    def strip(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples are beside an outline of the head, and go with it."""
        reach = self.original.settings.band * self.original.size
        return smooth_step(self.view.away, reach, 0.23 * reach)

    @cached_property
    def strip_source(self) -> np.ndarray:
        """(H, W, 2) float32 pixels of the old picture that show samples of the strip."""
        return self.original.window.places + self._outline_shift

    @cached_property
    def _outline_shift(self) -> np.ndarray:
        """(H, W, 2) float32: the shift of the outline that is nearest, without what makes neighbours differ."""
        window = self.original.window
        spread = 0.3 * self.original.settings.band * self.original.size
        # A wide blur needs no more than one sample a pixel.
        each = np.s_[:: window.fine, :: window.fine]
        row, column = self.view.outline
        strip = (self.strip[each] > 0).astype(np.float32)
        shift = self.shift[row[each], column[each]]
        shares = blurred(np.dstack([shift * strip[..., None], strip]), spread)
        shift = shares[..., :2] / np.maximum(shares[..., 2:], _LEVEL)
        return cv2.resize(shift, window.size, interpolation=cv2.INTER_LINEAR)

    @cached_property
    def motion(self) -> np.ndarray:
        """(H, W) float32 pixels: how far what samples show, or showed, or what is beside it, has moved."""
        own = np.maximum(_lengths(self.shift), self._gone)
        own = np.maximum(own, self.original.settings.moved * (1 - self._kept) * self.view.inside)
        beside = _lengths(self._outline_shift) * (self.strip > 0)
        return np.maximum(own, np.maximum(beside, self._left * (self._stained > 0)))

    @cached_property
    def stain(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far the old picture shows, at its samples, an outline that moved away."""
        return self._stained * smooth_step(self._left, 0.5, 1.5)

    @cached_property
    def _left(self) -> np.ndarray:
        """(H, W) pixels by which the outline that is nearest in the old picture has moved."""
        return self._gone[self.original.view.outline]

    @cached_property
    def _stained(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far the old picture's samples may show what is beside an outline."""
        reach = self.original.settings.stain * self.original.size
        return smooth_step(self.original.view.away, reach, reach / 3)

    def look(self, samples: np.ndarray, source: np.ndarray | None = None) -> np.ndarray:
        """What samples (H, W, ...) of the old picture are at pixels of it (H, W, 2), or at the source."""
        columns, rows = self._at if source is None else _at(source, self.original.window)
        return cv2.remap(samples, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    @cached_property
    def _at(self) -> tuple[np.ndarray, np.ndarray]:
        """Columns and rows (H, W) float32 of the source among samples."""
        return _at(self.source, self.original.window)

    def picture(self, source: np.ndarray, picture: np.ndarray) -> np.ndarray:
        """(H, W, 3) float32 colours of a picture (H, W, 3) at pixels of it (H, W, 2)."""
        x, y = np.moveaxis(source.astype(np.float32), 2, 0)
        colours = cv2.remap(picture.astype(np.float32), x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.clip(colours, 0, 255)

    @cached_property
    def light_ratio(self) -> np.ndarray:
        """(H, W, 3) float32 factors of sRGB by which what moved is brighter than the old picture shows it; (1, 1, 3)
        ones where this tells no light.
        """
        light = self.original.light
        if light is None:
            return np.ones((1, 1, 3), np.float32)
        before = light.shade_mesh(self.original.depiction.vertices, self.original.faces)
        ratio = self.view.carried(np.clip(self._lit / before, *self.original.settings.light))
        return np.where(self.view.covered[..., None], ratio, 1)

    @cached_property
    def _lit(self) -> np.ndarray:
        """(V, 3) factors of sRGB with which the light of the old picture falls on the vertices."""
        light = self.original.light
        return np.ones_like(self.vertices) if light is None else light.shade_mesh(self.vertices, self.original.faces)

    @cached_property
    def shade(self) -> np.ndarray:
        """(H, W, 3) float32 factors of sRGB by which what is drawn anew is lit; a mouth is dark in its depth."""
        faces = self.original.faces
        normals = smooth_normals(self.vertices, faces)
        shade = self._lit.copy()
        inside = np.flatnonzero(self.original.wall > 0)
        sky = sky_visibility(self.vertices, faces, normals, inside)
        wall = self.original.wall[inside, None]
        share = light_received(sky, normals[inside], DIRECTIONS, [None])[:, :1]
        deep = self.original.deep[inside, None]
        shade[inside] *= 1 - wall + wall * (deep + (1 - deep) * share) ** (1 / GAMMA)
        return self.view.carried(shade)


def _at(source: np.ndarray, window: Window) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows (H, W) float32 of pixels (H, W, 2) of a picture among the samples of a window."""
    columns = (source[..., 0] - np.float32(window.left) + 0.5) * window.fine - 0.5
    rows = (source[..., 1] - np.float32(window.top) + 0.5) * window.fine - 0.5
    return columns.astype(np.float32, copy=False), rows.astype(np.float32, copy=False)


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """(H, W) of vectors (H, W, 2)."""
    x, y = np.moveaxis(vectors, 2, 0)
    return np.sqrt(x * x + y * y)


def _areas(placed: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) twice the areas of triangles in the picture, below zero where they are turned away from the camera."""
    return _twice_areas(placed[faces, :2])


def _twice_areas(corners: np.ndarray) -> np.ndarray:
    """(F,) twice the areas of triangles (F, 3, 2), with their signs."""
    one = corners[:, 1] - corners[:, 0]
    two = corners[:, 2] - corners[:, 0]
    return one[:, 1] * two[:, 0] - one[:, 0] * two[:, 1]
