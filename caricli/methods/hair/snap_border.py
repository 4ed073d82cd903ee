"""Hair moved until its border in the picture is that of a mask."""

from dataclasses import replace
from operator import itemgetter

import numpy as np
from scipy.spatial import KDTree

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.move_border import border_field, follow_field, mask_border
from caricli.methods.hair.move_skull import lower_skull, raise_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.tidy_hair import GOOD, tidy_hair
from caricli.methods.hair.visible_hair import facing, raster_hair, seen_faces, union_share
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.structures import Camera, Hair, Mesh
from caricli.template.template import Template

# Of the head's height, over which a border's movements are spread, round after round.
_WIDTHS = (0.015, 0.01, 0.006, 0.004, 0.003, 0.003, 0.003)
# Intersection over union with the mask, from which on its border is met, once what is before bare skin is under it.
_MET = 0.98
_RAISE = 0.02  # of the head's height, by which the skull is raised at most
_TRIM = 3  # round in which what stands before bare skin goes under it, and from the second after it on where it is far
_BEFORE = 0.004  # of the head's height: so far from the mask hair is not before bare skin
_BESIDE = 0.01  # the same of the background, where borders move
_SLOPES = ((0.2, 0.6), (0.6, 3.0))  # of cosines between surface and view, in which hair rises from where it goes under


def snap_border(
    hair: Hair,
    head: Template,
    camera: Camera,
    mask: HairMask,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> tuple[Hair, Template, float]:
    """Move a shell so that what the camera sees of it ends where the mask ends, and the skull so that it is under it.

    Every pixel of either border wants to be at the nearest of the other one; what they want, averaged with weights that
    fall with the distance, moves what is near them, in smaller and smaller neighbourhoods. Where the surface faces the
    camera it goes along the skin, where it is seen from aside out and in. In the last round the skull is raised where
    hair is seen still and the picture has skin: a forehead that is too low shows the hair behind. The best of the
    rounds counts, which end where the border is met, its gaps filled where it is far from the mask, without its loose
    parts. Movements go over smoothly into what is not seen and fade out there, and what stands before bare skin goes
    under it in a slope.

    hair: Hair on the head. head: Template in the shape of the face. camera: of the picture. mask: HairMask.
    Returns Hair with the same polygons and roots, the head, and the intersection over union of what the camera sees of
    the hair and the mask.
    """
    sphere = HeadSphere(head, settings, fine=True)
    heights = sphere.heights(hair.shell.vertices)
    above = heights > 0
    lowest = np.where(above, np.minimum(heights, settings.least * head.height), -np.inf)
    over = np.zeros(len(heights), bool)
    net = ShellNet(hair.shell, sphere)
    start = hair.shell
    size = camera.scale * head.height
    outside = _outside(mask, size)
    seen = seen_faces(head, hair, camera, mask.pixels.shape)
    skin = sphere
    best = (union_share(seen >= 0, mask.pixels), hair, skin)
    wanted = mask_border(mask.pixels, size)
    for number, width in enumerate((*_WIDTHS, None)):
        if number > _TRIM and best[0] >= _MET:
            break
        if width is not None:
            points = follow_field(hair.shell, start, sphere, camera, border_field(seen >= 0, wanted, size, width), net)
        elif best[0] < GOOD:
            points = hair.shell.vertices
            wrong = _seen_places(skin.head, hair, camera, outside & ~mask.behind)
            skin = sphere.with_head(raise_skull(skin.head, sphere, sphere.farthest(wrong), _RAISE * head.height))
            lowest = np.full_like(lowest, -np.inf)
        else:
            break
        if number == _TRIM or (number > _TRIM + 1 and best[0] < GOOD):
            over = over | _over(seen, hair, camera, outside)
        inner = hair.shell.faces[(above & ~over)[hair.shell.faces].all(1)]
        most = sphere.cover(points, inner, *np.meshgrid(sphere.longitudes, sphere.angles))
        # Triangles of the skull are larger than those of hair: without a gap they come through between their corners.
        skin = sphere.with_head(lower_skull(skin.head, sphere, most - settings.least * head.height))
        ramp = _ramp(hair.shell.with_vertices(points), over, camera)
        depths = np.where(over, settings.deep, settings.under) * head.height
        points = _seated(points, lowest, np.where(above & ~over, ramp, -depths), skin)
        hair = replace(hair, shell=hair.shell.with_vertices(points))
        seen = seen_faces(skin.head, hair, camera, mask.pixels.shape)
        best = max(best, (union_share(seen >= 0, mask.pixels), hair, skin), key=itemgetter(0))
    hair, head = tidy_hair(best, camera, mask, net, settings)
    return hair, head, union_share(seen_faces(head, hair, camera, mask.pixels.shape) >= 0, mask.pixels)


def _ramp(shell: Mesh, over: np.ndarray, camera: Camera) -> np.ndarray:
    """(V,) metres, how far above the skin a shell may rise, the less the nearer it is to what goes under it (V,) bool.

    Hair that the camera sees from aside rises in a gentle slope, or a step is seen from there.
    """
    if not over.any():
        return np.full(len(over), np.inf)
    away, _ = KDTree(shell.vertices[over]).query(shell.vertices)
    ramp: np.ndarray = away * np.interp(facing(shell, camera), *_SLOPES)
    return ramp


def _seated(points: np.ndarray, lowest: np.ndarray, highest: np.ndarray, skin: HeadSphere) -> np.ndarray:
    """Points (N, 3) moved until they are from lowest to highest (N,) metres above the skin."""
    longitudes, angles, radii = skin.seen_from(points)
    ground = skin.ground(longitudes, angles)
    return skin.points(longitudes, angles, np.clip(radii, ground + lowest, ground + highest))


def _outside(mask: HairMask, height: float) -> np.ndarray:
    """(H, W) bool: where no hair may be seen. height: pixels of the head."""
    return exact_distance_to(mask.pixels) > np.where(mask.behind, _BESIDE, _BEFORE) * height


def _over(seen: np.ndarray, hair: Hair, camera: Camera, outside: np.ndarray) -> np.ndarray:
    """(N,) bool: vertices of hair that are seen outside (H, W) bool.

    seen: (H, W) of `seen_faces`.
    """
    corners = np.unique(hair.shell.faces[np.unique(seen[outside & (seen >= 0)])])
    x, y = camera.project(hair.shell.vertices[corners]).T
    over = np.zeros(len(hair.shell.vertices), bool)
    over[corners] = sample_pixels(outside.astype(np.float32), x, y, border=0.0) > 0.5
    return over


def _seen_places(head: Mesh, hair: Hair, camera: Camera, pixels: np.ndarray) -> np.ndarray:
    """(N, 3) places of hair that are seen among pixels (H, W) bool."""
    both, raster = raster_hair(head, hair, camera, pixels.shape)
    shown = pixels & (raster.face >= len(head.faces))
    corners = both.vertices[both.faces[raster.face[shown]]]
    return np.einsum("nk,nkc->nc", raster.barycentric[shown], corners)
