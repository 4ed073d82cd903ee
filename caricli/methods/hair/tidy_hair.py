"""Hair that has been moved to its border, without loose parts, ridges and gaps."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import minimum_filter

from caricli.methods.hair.hair_view import HeadView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.move_border import border_field, follow_field, mask_border
from caricli.methods.hair.move_skull import lower_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.slope_edges import slope_edges
from caricli.methods.hair.visible_hair import facing, visible_hair
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.structures import Camera, Hair
from caricli.template.template import Template

GOOD = 0.93
"""Intersection over union with the mask from which on a shell is not far: no skull is raised and no gap filled."""

_LAST_WIDTH = 0.006  # of the head's height, over which a border's movements are spread once hair is laid
_CORNERS = 5  # rows and columns around a direction, in which nothing of hair is nearer than the skull
_INSIDE = 41  # the same, in which hair does not end
_JOINED = 0.3  # of the least thickness of hair: what is less far above the skin holds nothing together
_LOOSE = 0.1  # of the largest part of hair: a part with less of it is loose,
_LOCK = 0.01  # and one with still less is no lock
_STRIP = 0.03  # of the head's height: what comes out of the skin once more is at least so long
_EVEN = ((-0.4, -0.1, 0.5, 0.8), (0.0, 0.5, 0.5, 0.0))  # of cosines, how far a height is evened in a round
_EVEN_ROUNDS = 2
_ASIDE = 0.6  # cosine between surface and view, below which hair is seen from aside


def tidy_hair(
    snapped: tuple[float, Hair, HeadSphere],
    camera: Camera,
    mask: HairMask,
    net: ShellNet,
    settings: ShellSettings,
) -> tuple[Hair, Template]:
    """Hair without loose parts, ridges, and gaps where it is far from the mask, and the head whose skull is well under.

    snapped: intersection over union with the mask, Hair and HeadSphere of the head. net: ShellNet of the hair.
    """
    share, hair, skin = snapped
    if share < GOOD:
        hair = _filled(hair, skin, camera, mask, net, settings)
    hair = _nearer(_evened(hair, skin, camera, net), skin, camera, mask, net)
    # What moved to the mask may hang together no longer.
    hair = _hanging_together(hair, skin, camera, net, settings)
    hair = slope_edges(hair, skin, camera, visible_hair(skin.head, hair, camera, mask.pixels.shape), settings)
    return hair, _clear_of(hair, skin, settings)


def _filled(
    hair: Hair, skin: HeadSphere, camera: Camera, mask: HairMask, net: ShellNet, settings: ShellSettings
) -> Hair:
    """Hair that is there wherever the picture shows it: slopes and a raised skull took some. Laid thinly, it ends where
    its polygons do, and its border moves once more.

    skin: HeadSphere of the head. net: ShellNet of the hair.
    """
    seen = HeadView(skin.head, camera, mask.pixels.shape)
    hair = _nearer(_laid(hair, skin, seen, mask, net, settings), skin, camera, mask, net)
    return _laid(hair, skin, seen, mask, net, settings)


def _nearer(hair: Hair, skin: HeadSphere, camera: Camera, mask: HairMask, net: ShellNet) -> Hair:
    """Hair whose border has moved to that of the mask once more.

    skin: HeadSphere of the head. net: ShellNet of the hair.
    """
    size = camera.scale * skin.head.height
    shown = visible_hair(skin.head, hair, camera, mask.pixels.shape)
    field = border_field(shown, mask_border(mask.pixels, size), size, _LAST_WIDTH)
    return replace(hair, shell=hair.shell.with_vertices(follow_field(hair.shell, hair.shell, skin, camera, field, net)))


def _laid(hair: Hair, skin: HeadSphere, seen: HeadView, mask: HairMask, net: ShellNet, settings: ShellSettings) -> Hair:
    """Hair that lies at least thinly where the picture shows it on the skin, as far as whole triangles of it hang
    together with the rest.

    skin: HeadSphere of the head. seen: HeadView of it. net: ShellNet of the hair.
    """
    longitudes, angles, radii = skin.seen_from(hair.shell.vertices)
    ground = skin.ground(longitudes, angles)
    feet = skin.points(longitudes, angles, ground)
    x, y = seen.camera.project(feet).T
    hairy = seen.shows(feet) & (sample_pixels(mask.pixels.astype(np.float32), x, y, border=0.0) > 0.5)
    least = ground + settings.least * skin.head.height
    there = radii > least
    whole = net.large_parts(_with_faces(hair.shell.faces, hairy | there))
    laid = np.where(hairy & whole & (whole & there).any(), np.maximum(radii, least), radii)
    return replace(hair, shell=hair.shell.with_vertices(skin.points(longitudes, angles, laid)))


def _clear_of(hair: Hair, sphere: HeadSphere, settings: ShellSettings) -> Template:
    """The head of a sphere whose skull is under hair between its vertices, too, and where it is drawn rounder than it
    is; not near the hair's ends, which it would uncover."""
    above = sphere.heights(hair.shell.vertices) > 0
    outer = hair.shell.faces[above[hair.shell.faces].all(1)]
    most = sphere.cover(hair.shell.vertices, outer, *np.meshgrid(sphere.longitudes, sphere.angles))
    mode = ("nearest", "wrap")
    inside = minimum_filter(np.isfinite(most), _INSIDE, mode=mode)
    lowest = minimum_filter(most, _CORNERS, mode=mode) - settings.least * sphere.head.height
    return lower_skull(sphere.head, sphere, np.where(inside, lowest, np.inf))


def _hanging_together(hair: Hair, skin: HeadSphere, camera: Camera, net: ShellNet, settings: ShellSettings) -> Hair:
    """Hair whose loose parts are under the skin where they are slivers, or are seen from aside; others are locks.

    Strips along the edge that hang on it at an end are slivers, too, and those that come out once more beyond it.
    skin: HeadSphere of the head. net: ShellNet of the hair.
    """
    longitudes, angles, radii = skin.seen_from(hair.shell.vertices)
    ground = skin.ground(longitudes, angles)
    above = net.without_strips(radii > ground + _JOINED * settings.least * skin.head.height)
    # What comes out in the hollow of an ear hangs on nothing but what is in its flesh.
    near_ears = skin.near_ears(hair.shell.vertices)
    above[near_ears] &= ~skin.encloses(hair.shell.vertices[near_ears])
    above &= ~skin.in_neck(hair.shell.vertices)
    above &= ~net.out_again(above, hair.shell.vertices, _STRIP * skin.head.height)
    joined, locks = (net.large_parts(above, least) for least in (_LOOSE, _LOCK))
    kept = joined | (locks & (facing(hair.shell, camera) >= _ASIDE))
    # The hollow of an ear is deeper than the skin between what is around it.
    depth = np.where(near_ears, settings.deep, settings.under) * skin.head.height
    buried = np.where(kept, radii, np.minimum(radii, ground - depth))
    return replace(hair, shell=hair.shell.with_vertices(skin.points(longitudes, angles, buried)))


def _with_faces(faces: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """(V,) bool: of vertices (V,) bool those of faces (F, 3) whose corners are all among them."""
    whole = np.zeros_like(chosen)
    whole[faces[chosen[faces].all(1)]] = True
    return whole


def _evened(hair: Hair, skin: HeadSphere, camera: Camera, net: ShellNet) -> Hair:
    """Hair as high above the skin as around where it is seen from aside: what moved it there left ridges.

    skin: HeadSphere of the head. net: ShellNet of the hair.
    """
    longitudes, angles, radii = skin.seen_from(hair.shell.vertices)
    ground = skin.ground(longitudes, angles)
    share = np.interp(facing(hair.shell, camera), *_EVEN)
    heights = np.maximum(radii - ground, 0)
    for _ in range(_EVEN_ROUNDS):
        heights += share * (net.mean @ heights - heights)
    even = np.where(radii > ground, ground + heights, radii)
    return replace(hair, shell=hair.shell.with_vertices(skin.points(longitudes, angles, even)))
