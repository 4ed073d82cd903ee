"""The skin at the edge of hair in the colours of the hair, so that neither a hard line nor bare skin borders it."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import label

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import reach_inside, usual_reach
from caricli.methods.hair.make_shell import unrolled_to_uv
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.texture.texture_face import FaceTexture
from caricli.render.pixels.paint import mix
from caricli.render.pixels.sample_texture import sample_texture
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Hair, Mesh
from caricli.template.annotation import EARS
from caricli.template.template import Template

_SEEN = 0.005  # of the head's height, over which hair fades out where the picture shows the skin beside it
_HIDDEN = (0.03, 0.015)  # the same where it does not, of dark hair and of light hair
_FADE = (-0.01, 0.045)  # of the same, to the usual hairline: from where on and with which skin is as dark as hair
_THIN = (0.98, 0.35)  # of the colour of hair, that cropped hair has at most: skin shines through light hair
_LIGHTER = (0, 60)  # levels of 255 by which hair is lighter than skin, from where on it is no dark and with which light
_UNSEEN = 0.25  # from which on the picture decides, not what is usual
_EAR = (0.3, 0.9)  # of a triangle that is not an ear's, from where on and with which hair may grow
_GRAIN = (0.2, 0.1)  # of the share of hair, that it varies from texel to texel, of dark and of light hair
_HARDLY = 0.02  # from which on a texel is seen at all
_GLIMPSE = 0.003  # of a texture: what is seen of skin is more than this, or does not count
_SPECK = 20  # directions of a sphere's: a sliver of hair that comes out of the skin alone is none
_MIRRORED = 0.5  # of the way from the whorl to the edge: colours beyond the edge are mirrored so far


@dataclass(frozen=True, eq=False)
class _Skin:
    """N texels around hair.

    rows, columns: (N,) in the texture. to_hair, usual: (N,) shares of the head's height, to the hair's edge and to the
    usual hairline. bare: (N,) from 0 to 1, how far no ear is there. in_hair: (N, 2) UVs of the hair there.
    """

    rows: np.ndarray
    columns: np.ndarray
    to_hair: np.ndarray
    usual: np.ndarray
    bare: np.ndarray
    in_hair: np.ndarray


class Scalp:
    """What skin around hair is shaded by, that no picture says: the hair's edge, and the usual hairline."""

    def __init__(self, head: Template, hair: Hair, size: int | None = None) -> None:
        """head: Template with UVs, its skull under the hair. hair: Hair on it. size: texels, width and height of its
        texture, where they are known before it is there.
        """
        self.head = head
        self.hair = hair
        self.settings = ShellSettings()
        self.sphere = HeadSphere(head, self.settings, fine=True)
        around, down = np.meshgrid(self.sphere.longitudes, self.sphere.angles)
        outer = self.sphere.cover(hair.shell.vertices, hair.shell.faces, around, down)
        covered = _without_specks(np.isfinite(outer) & (outer > self.sphere.radii))
        self.to_hair = reach_inside(self.sphere, covered) / head.height
        self.usual = usual_reach(self.sphere, self.settings) / head.height
        self.part = _near(head, self.sphere, np.maximum(self.to_hair + max(_HIDDEN), self.usual - _FADE[0]) > 0)
        self.skin = None if size is None else self._skin(size)

    def shaded(self, texture: FaceTexture, picture: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """(S, S, 3) uint8: a texture's picture with skin around hair painted as if this were cropped there.

        It fades out around the shell, and where the picture does not show the skin it goes on to the usual hairline.
        Of hair that is lighter than the skin, less is seen.

        texture: FaceTexture of the head. picture: (S, S, 3) uint8, of the hair. generator: of the grain.
        """
        skin = self.skin or self._skin(len(texture.image))
        seen = np.where(_glimpses(texture.seen)[skin.rows, skin.columns], 0, texture.seen[skin.rows, skin.columns])
        colours = sample_texture(picture, skin.in_hair)
        shaded = texture.image.copy()
        hidden, thin, rough = _limits(colours, shaded[skin.rows, skin.columns][skin.to_hair < 0])
        beside = smooth_step(skin.to_hair, -(hidden + seen * (_SEEN - hidden)), 0)
        cropped = smooth_step(seen, _UNSEEN, 0) * smooth_step(skin.usual, *_FADE)
        share = np.maximum(beside, thin * cropped) * skin.bare
        grain = generator.normal(0, rough, len(share))
        share = np.clip(share + 4 * grain * share * (1 - share), 0, 1)
        shaded[skin.rows, skin.columns] = np.round(mix(shaded[skin.rows, skin.columns], colours, share))
        return pad_texture(shaded, texture.covered)

    def _skin(self, size: int) -> "_Skin":
        """Texels of skin around hair in a texture of a size."""
        sphere = self.sphere
        face, weights = uv_map(self.part, size)
        rows, columns = np.nonzero(face >= 0)
        corners = self.part.faces[face[rows, columns]]
        weights = weights[rows, columns]
        points = np.einsum("nk,nkc->nc", weights, self.part.vertices[corners])
        longitudes, angles, _ = sphere.seen_from(points)
        bare = ~self.head.mask(*EARS)[corners]
        ends = _ends(self.hair, sphere, self.settings, longitudes)
        return _Skin(
            rows,
            columns,
            sphere.sample(self.to_hair, longitudes, angles),
            sphere.sample(self.usual, longitudes, angles),
            smooth_step((weights * bare).sum(1), *_EAR),
            unrolled_to_uv(longitudes, _mirrored(angles / ends)),
        )


def _limits(hair: np.ndarray, skin: np.ndarray) -> tuple[float, float, float]:
    """Of hair and skin of colours (N, 3) and (M, 3): over which share of the head's height hair fades out where it is
    not seen, how much of its colour cropped hair has at most, and its grain."""
    lighter = hair.mean() - skin.mean() if len(skin) else 0.0
    light = smooth_step(lighter, *_LIGHTER)
    hidden, thin, rough = (float(np.interp(light, (0, 1), limits)) for limits in (_HIDDEN, _THIN, _GRAIN))
    return hidden, thin, rough


def _without_specks(covered: np.ndarray) -> np.ndarray:
    """Which directions (R, C) hair covers, where it covers more than a few around, or leaves more than a few free."""
    for value in (True, False):
        parts, _ = label(covered == value)
        specks = np.bincount(parts.ravel()) <= _SPECK
        specks[0] = False
        covered = covered ^ specks[parts]
    return covered


def _glimpses(seen: np.ndarray) -> np.ndarray:
    """(S, S) bool: where but a few texels are seen (S, S), from 0 to 1; those would be holes in hair."""
    _, parts, stats, _ = cv2.connectedComponentsWithStats((seen > _HARDLY).astype(np.uint8))
    few = stats[:, cv2.CC_STAT_AREA] < _GLIMPSE * seen.size
    few[0] = False
    glimpses: np.ndarray = few[parts]
    return glimpses


def _near(head: Template, sphere: HeadSphere, places: np.ndarray) -> Mesh:
    """A head's triangles, but for ears, with a corner among places (R, C) bool of a sphere."""
    longitudes, angles, _ = sphere.seen_from(head.vertices)
    near = sphere.sample(places.astype(float), longitudes, angles) > 0
    near &= ~head.mask("inner_mouth", "eye_socket_left", "eye_socket_right", "nostril_left", "nostril_right")
    chosen = near[head.faces].any(1) & ~head.mask(*EARS)[head.faces].all(1)
    return Mesh(head.vertices, head.faces[chosen], head.uvs, head.uv_faces[chosen])


def _mirrored(shares: np.ndarray) -> np.ndarray:
    """Shares of the way from the whorl to the edge of a shell, those beyond it mirrored into the shell."""
    return np.where(shares > 1, np.maximum(2 - shares, _MIRRORED), shares)


def _ends(hair: Hair, sphere: HeadSphere, settings: ShellSettings, longitudes: np.ndarray) -> np.ndarray:
    """(N,) angles where a shell ends at longitudes (N,)."""
    turns, angles, _ = sphere.seen_from(hair.shell.vertices[-settings.columns :])
    order = np.argsort(turns)
    return np.interp(longitudes, turns[order], angles[order], period=2 * np.pi)
