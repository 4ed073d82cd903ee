"""The skin at the edge of hair in the colours of the hair, so that neither a hard line nor bare skin borders it."""

import numpy as np

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import reach_inside, usual_reach
from caricli.methods.hair.make_shell import unrolled_to_uv
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.texture.texture_face import FaceTexture
from caricli.render.paint import mix, smooth_step
from caricli.render.sample_texture import sample_texture
from caricli.render.uv_map import pad_texture, uv_map
from caricli.structures import Hair, Mesh
from caricli.template.template import Template

_SEEN = 0.005  # of the head's height, over which hair fades out where the picture shows the skin beside it
_HIDDEN = 0.03  # the same where it does not
_FADE = (-0.01, 0.045)  # of the same, to the usual hairline: from where on and with which skin is as dark as hair
_THIN = 0.95  # of the colour of hair, that cropped hair has at most
_UNSEEN = 0.25  # from which on the picture decides, not what is usual
_EAR = (0.3, 0.9)  # of a triangle that is not an ear's, from where on and with which hair may grow
_GRAIN = 0.2  # of the share of hair, that it varies from texel to texel
_MIRRORED = 0.5  # of the way from the whorl to the edge: colours beyond the edge are mirrored so far


def shade_scalp(
    head: Template,
    texture: FaceTexture,
    hair: Hair,
    picture: np.ndarray,
    generator: np.random.Generator,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """Paint skin around hair as if this were cropped there.

    It fades out around the shell, and where the picture does not show the skin it goes on to the usual hairline.

    head: Template with UVs, its skull under the hair. texture: FaceTexture of it. hair: Hair on it. picture:
    (S, S, 3) uint8, of the hair. generator: of the grain. Returns (S, S, 3) uint8, the texture's picture with it.
    """
    sphere = HeadSphere(head, settings, fine=True)
    around, down = np.meshgrid(sphere.longitudes, sphere.angles)
    outer = sphere.cover(hair.shell.vertices, hair.shell.faces, around, down)
    to_hair = reach_inside(sphere, np.isfinite(outer) & (outer > sphere.radii)) / head.height
    usual = usual_reach(sphere, settings) / head.height
    part = _near(head, sphere, np.maximum(to_hair + _HIDDEN, usual - _FADE[0]) > 0)
    face, weights = uv_map(part, len(texture.image))
    rows, columns = np.nonzero(face >= 0)
    corners = part.vertices[part.faces[face[rows, columns]]]
    points = np.einsum("nk,nkc->nc", weights[rows, columns], corners)
    longitudes, angles, _ = sphere.seen_from(points)
    seen = texture.seen[rows, columns]
    beside = smooth_step(sphere.sample(to_hair, longitudes, angles), -(_HIDDEN + seen * (_SEEN - _HIDDEN)), 0)
    cropped = smooth_step(seen, _UNSEEN, 0) * smooth_step(sphere.sample(usual, longitudes, angles), *_FADE)
    skin = ~head.mask("ear_left", "ear_right")[part.faces[face[rows, columns]]]
    share = np.maximum(beside, _THIN * cropped) * smooth_step((weights[rows, columns] * skin).sum(1), *_EAR)
    grain = generator.normal(0, _GRAIN, len(share))
    share = np.clip(share + 4 * grain * share * (1 - share), 0, 1)
    ends = _ends(hair, sphere, settings, longitudes)
    colours = sample_texture(picture, unrolled_to_uv(longitudes, _mirrored(angles / ends)))
    shaded = texture.image.copy()
    shaded[rows, columns] = np.round(mix(shaded[rows, columns], colours, share))
    return pad_texture(shaded, texture.covered)


def _near(head: Template, sphere: HeadSphere, places: np.ndarray) -> Mesh:
    """A head's triangles, but for ears, with a corner among places (R, C) bool of a sphere."""
    longitudes, angles, _ = sphere.seen_from(head.vertices)
    near = sphere.sample(places.astype(float), longitudes, angles) > 0
    near &= ~head.mask("inner_mouth", "eye_socket_left", "eye_socket_right", "nostril_left", "nostril_right")
    chosen = near[head.faces].any(1) & ~head.mask("ear_left", "ear_right")[head.faces].all(1)
    return Mesh(head.vertices, head.faces[chosen], head.uvs, head.uv_faces[chosen])


def _mirrored(shares: np.ndarray) -> np.ndarray:
    """Shares of the way from the whorl to the edge of a shell, those beyond it mirrored into the shell."""
    return np.where(shares > 1, np.maximum(2 - shares, _MIRRORED), shares)


def _ends(hair: Hair, sphere: HeadSphere, settings: ShellSettings, longitudes: np.ndarray) -> np.ndarray:
    """(N,) angles where a shell ends at longitudes (N,)."""
    turns, angles, _ = sphere.seen_from(hair.shell.vertices[-settings.columns :])
    order = np.argsort(turns)
    return np.interp(longitudes, turns[order], angles[order], period=2 * np.pi)
