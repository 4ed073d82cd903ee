"""Short hair that rises gently from where it ends."""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.render.pixels.widen_mask import widen_mask
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Hair, Mesh

_SLOPE = 0.7  # in which hair rises at most from its edge
_ASIDE = ((0.01, 0.04), (0.0, 1.0))  # of the head's height from the outline, how far it does
_SHORT = ((0.03, 0.06), (1.0, 0.0))  # of the head's height, how far hair that stands so high does: what is long hangs


def slope_edges(hair: Hair, skin: HeadSphere, camera: Camera, shown: np.ndarray, settings: ShellSettings) -> Hair:
    """Hair that rises in a slope from where it goes under the skin: what moved its border had cut through it.

    What the picture shows of its outline before what is behind the head stays, and so do the ends of long hair.

    hair: Hair on the head. skin: HeadSphere of the head. camera: of the picture. shown: (H, W) bool, the pixels where
    it is in front.
    """
    longitudes, angles, radii = skin.seen_from(hair.shell.vertices)
    ground = skin.ground(longitudes, angles)
    under = radii <= ground
    if not under.any():
        return hair
    feet = skin.points(longitudes, angles, ground)
    height = skin.head.height
    highest = ground + settings.least * height + _SLOPE * KDTree(feet[under]).query(feet)[0]
    x, y = camera.project(hair.shell.vertices).T
    away = sample_pixels(_to_outline(shown, skin.head, camera), x, y) / (camera.scale * height)
    share = np.interp(away, *_ASIDE) * np.interp((radii - ground) / height, *_SHORT)
    sloped = radii - np.where(under, 0, share * np.maximum(radii - highest, 0))
    return replace(hair, shell=hair.shell.with_vertices(skin.points(longitudes, angles, sloped)))


def _to_outline(shown: np.ndarray, head: Mesh, camera: Camera) -> np.ndarray:
    """(H, W) pixels to the border of hair that is shown (H, W) bool where this is not before the head."""
    raster = rasterise(camera.place(head.vertices), head.faces, *shown.shape[::-1])
    behind = (raster.face < 0) & ~shown
    outline = shown & widen_mask(behind, 1)
    return exact_distance_to(outline)
