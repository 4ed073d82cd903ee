"""Hair moved until its border in the picture is that of a mask."""

from dataclasses import replace
from operator import itemgetter

import cv2
import igl
import numpy as np
import scipy.sparse as sp
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from caricli.geometry.join_meshes import join_meshes
from caricli.methods.hair.hair_view import HeadView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.move_skull import lower_skull, raise_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.slope_edges import slope_edges
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.render.pixels.widen_mask import widen_mask
from caricli.render.visibility.rasterise import Raster, rasterise
from caricli.structures import Camera, Hair, Mesh
from caricli.template.template import Template

_WIDTHS = (0.015, 0.01, 0.006, 0.004, 0.003, 0.003, 0.003)
_LAST_WIDTH = 0.006  # of the head's height, over which a border's movements are spread once hair is laid
_GOOD = 0.93  # intersection over union from which on a shell is not far: no skull is raised and no gap filled
_MET = 0.98  # the same from which on a border is met, once what stands before bare skin has gone under it
_CORNERS = 5  # rows and columns around a direction, in which nothing of hair is nearer than the skull
_INSIDE = 41  # the same, in which hair does not end
_RAISE = 0.02  # of the head's height, by which it is at most
_TRIM = 3  # round in which what stands before bare skin goes under it, and from the second after it on where it is far
_BEFORE = 0.004  # of the head's height: so far from the mask hair is not before bare skin
_BESIDE = 0.01  # the same of the background, where borders move
_REACH = 0.06  # of the head's height: borders farther apart than this are not of the same place
_FADING = 0.05  # of what a straight border weighs: less of it near moves less
_BACK = (-0.6, -0.2)  # cosines between surface and view, from which on and with which it moves along
_SKIN = (0.2, 0.6)  # cosines with which at most it moves out and in, and from which on along the skin
_STEEPEST = 0.5  # of the way out of a head, that is seen at least where hair is moved out and in
_HOLD = ((-0.6, -0.2, 0.2, 0.6), (0.0, 0.3, 0.3, 1.0))  # of cosines, how much counts what the picture says
_TOGETHER = 0.3  # weight of the neighbours' movement beside that
_STILL = 0.03  # weight of not moving, of what is behind
_ROUNDS = 10  # of bringing movements to neighbours, which reach so many edges behind what is seen
_SLOPES = (0.6, 3.0)  # at these cosines, in which hair rises at most from where it goes under the skin
_JOINED = 0.3  # of the least thickness of hair: what is less far above the skin holds nothing together
_LOOSE = 0.1  # of the largest part of hair: a part with less of it is loose,
_LOCK = 0.01  # and one with still less is no lock
_STRIP = 0.03  # of the head's height: what comes out of the skin once more is at least so long
_EVEN = ((-0.4, -0.1, 0.5, 0.8), (0.0, 0.5, 0.5, 0.0))  # of cosines, how far a height is evened in a round
_EVEN_ROUNDS = 2
_SOFT = 1.5  # pixels over which the way out of a border is looked for
_EDGE = 2  # pixels: the picture's end is no border


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
    longitudes, angles, radii = sphere.seen_from(hair.shell.vertices)
    heights = radii - sphere.sample(sphere.radii, longitudes, angles)
    above = heights > 0
    lowest = np.where(above, np.minimum(heights, settings.least * head.height), -np.inf)
    over = np.zeros(len(heights), bool)
    net = ShellNet(hair.shell, sphere)
    start = hair.shell
    size = camera.scale * head.height
    outside = _outside(mask, size)
    seen = _seen_faces(head, hair, camera, mask.pixels.shape)
    skin = sphere
    best = (union_share(seen >= 0, mask.pixels), hair, skin)
    wanted = _border(mask.pixels, size)
    for number, width in enumerate((*_WIDTHS, None)):
        if number > _TRIM and best[0] >= _MET:
            break
        if width is not None:
            points = _brought(hair.shell, start, sphere, camera, _field(seen >= 0, wanted, size, width), net)
        elif best[0] < _GOOD:
            points = hair.shell.vertices
            wrong = _seen_places(skin.head, hair, camera, outside & ~mask.behind)
            skin = sphere.with_head(raise_skull(skin.head, sphere, sphere.farthest(wrong), _RAISE * head.height))
            lowest = np.full_like(lowest, -np.inf)
        else:
            break
        if number == _TRIM or (number > _TRIM + 1 and best[0] < _GOOD):
            over = over | _over(seen, hair, camera, outside)
        inner = hair.shell.faces[(above & ~over)[hair.shell.faces].all(1)]
        most = sphere.cover(points, inner, *np.meshgrid(sphere.longitudes, sphere.angles))
        # Triangles of the skull are larger than those of hair: without a gap they come through between their corners.
        skin = sphere.with_head(lower_skull(skin.head, sphere, most - settings.least * head.height))
        ramp = _ramp(hair.shell.with_vertices(points), over, camera)
        depths = np.where(over, settings.deep, settings.under) * head.height
        points = _seated(points, lowest, np.where(above & ~over, ramp, -depths), skin)
        hair = replace(hair, shell=hair.shell.with_vertices(points))
        seen = _seen_faces(skin.head, hair, camera, mask.pixels.shape)
        best = max(best, (union_share(seen >= 0, mask.pixels), hair, skin), key=itemgetter(0))
    hair, head = _tidied(best, camera, mask, net, settings)
    return hair, head, union_share(_seen_faces(head, hair, camera, mask.pixels.shape) >= 0, mask.pixels)


def _tidied(
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
    if share < _GOOD:
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
    field = _field(shown, _border(mask.pixels, size), size, _LAST_WIDTH)
    return replace(hair, shell=hair.shell.with_vertices(_brought(hair.shell, hair.shell, skin, camera, field, net)))


def _laid(hair: Hair, skin: HeadSphere, seen: HeadView, mask: HairMask, net: ShellNet, settings: ShellSettings) -> Hair:
    """Hair that lies at least thinly where the picture shows it on the skin, as far as whole triangles of it hang
    together with the rest.

    skin: HeadSphere of the head. seen: HeadView of it. net: ShellNet of the hair.
    """
    longitudes, angles, radii = skin.seen_from(hair.shell.vertices)
    ground = skin.sample(skin.radii, longitudes, angles)
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
    longitudes, angles, radii = sphere.seen_from(hair.shell.vertices)
    above = radii > sphere.sample(sphere.radii, longitudes, angles)
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
    ground = skin.sample(skin.radii, longitudes, angles)
    above = net.without_strips(radii > ground + _JOINED * settings.least * skin.head.height)
    # What comes out in the hollow of an ear hangs on nothing but what is in its flesh.
    near_ears = skin.near_ears(hair.shell.vertices)
    above[near_ears] &= ~skin.encloses(hair.shell.vertices[near_ears])
    above &= ~skin.in_neck(hair.shell.vertices)
    above &= ~net.out_again(above, hair.shell.vertices, _STRIP * skin.head.height)
    joined, locks = (net.large_parts(above, least) for least in (_LOOSE, _LOCK))
    kept = joined | (locks & (_cosines(hair.shell, camera) >= _SKIN[1]))
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
    ground = skin.sample(skin.radii, longitudes, angles)
    share = np.interp(_cosines(hair.shell, camera), *_EVEN)
    heights = np.maximum(radii - ground, 0)
    for _ in range(_EVEN_ROUNDS):
        heights += share * (net.mean @ heights - heights)
    even = np.where(radii > ground, ground + heights, radii)
    return replace(hair, shell=hair.shell.with_vertices(skin.points(longitudes, angles, even)))


def union_share(first: np.ndarray, second: np.ndarray) -> float:
    """Intersection over union of two masks."""
    return float((first & second).sum() / max((first | second).sum(), 1))


def _ramp(shell: Mesh, over: np.ndarray, camera: Camera) -> np.ndarray:
    """(V,) metres, how far above the skin a shell may rise, the less the nearer it is to what goes under it (V,) bool.

    Hair that the camera sees from aside rises in a gentle slope, or a step is seen from there.
    """
    if not over.any():
        return np.full(len(over), np.inf)
    away, _ = KDTree(shell.vertices[over]).query(shell.vertices)
    ramp: np.ndarray = away * np.interp(_cosines(shell, camera), _SKIN, _SLOPES)
    return ramp


def _cosines(shell: Mesh, camera: Camera) -> np.ndarray:
    """(V,) cosines between a shell and the view."""
    # Vertices of nothing but triangles without area have no normal.
    cosines: np.ndarray = -np.nan_to_num(igl.per_vertex_normals(shell.vertices, shell.faces)) @ camera.rotation[2]
    return cosines


def _seated(points: np.ndarray, lowest: np.ndarray, highest: np.ndarray, skin: HeadSphere) -> np.ndarray:
    """Points (N, 3) moved until they are from lowest to highest (N,) metres above the skin."""
    longitudes, angles, radii = skin.seen_from(points)
    ground = skin.sample(skin.radii, longitudes, angles)
    return skin.points(longitudes, angles, np.clip(radii, ground + lowest, ground + highest))


def _outside(mask: HairMask, height: float) -> np.ndarray:
    """(H, W) bool: where no hair may be seen. height: pixels of the head."""
    return exact_distance_to(mask.pixels) > np.where(mask.behind, _BESIDE, _BEFORE) * height


def _over(seen: np.ndarray, hair: Hair, camera: Camera, outside: np.ndarray) -> np.ndarray:
    """(N,) bool: vertices of hair that are seen outside (H, W) bool.

    seen: (H, W) of `_seen_faces`.
    """
    corners = np.unique(hair.shell.faces[np.unique(seen[outside & (seen >= 0)])])
    x, y = camera.project(hair.shell.vertices[corners]).T
    over = np.zeros(len(hair.shell.vertices), bool)
    over[corners] = sample_pixels(outside.astype(np.float32), x, y, border=0.0) > 0.5
    return over


def _seen_places(head: Mesh, hair: Hair, camera: Camera, pixels: np.ndarray) -> np.ndarray:
    """(N, 3) places of hair that are seen among pixels (H, W) bool."""
    both, raster = _raster(head, hair, camera, pixels.shape)
    shown = pixels & (raster.face >= len(head.faces))
    corners = both.vertices[both.faces[raster.face[shown]]]
    return np.einsum("nk,nkc->nc", raster.barycentric[shown], corners)


def visible_hair(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: the pixels of a picture of a shape where hair is in front of the head."""
    return _seen_faces(head, hair, camera, shape) >= 0


def _seen_faces(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, int]) -> np.ndarray:
    """(H, W): which triangle of hair is in front in each pixel of a picture of a shape, below zero for none."""
    return _raster(head, hair, camera, shape)[1].face - len(head.faces)


def _raster(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, ...]) -> tuple[Mesh, Raster]:
    """Head and hair as one mesh, and the Raster of a picture of a shape."""
    both = join_meshes([head, hair.shell])
    return both, rasterise(camera.place(both.vertices), both.faces, shape[1], shape[0])


def _field(shown: np.ndarray, there: np.ndarray, height: float, width: float) -> np.ndarray:
    """(H, W, 2) pixels, x and y: how pixels move so that the border of a mask comes to another one, see `_border`.

    height: pixels of the head. width: share of it over which movements are spread.
    """
    here = _border(shown, height)
    total = np.zeros((*shown.shape, 3), np.float32)
    for start, end, way in ((here, there, 1), (there, here, -1)):
        if len(start) == 0 or len(end) == 0:
            continue
        away, nearest = KDTree(end).query(start, distance_upper_bound=_REACH * height)
        close = np.isfinite(away)
        ends = end[nearest[close]]
        # It acts where the shown border is: that is the one that moves.
        column, row = (start[close] if way > 0 else ends)[:, :2].astype(int).T
        move = way * (ends - start[close])[:, :2]
        np.add.at(total, (row, column), np.column_stack([move, np.ones(len(move))]))
    spread = max(width * height, 1.0)
    total = cv2.GaussianBlur(total, (0, 0), spread, borderType=cv2.BORDER_CONSTANT)
    usual = 2 / (np.sqrt(2 * np.pi) * spread)
    return total[..., :2] / (total[..., 2:] + _FADING * usual)


def _border(mask: np.ndarray, height: float) -> np.ndarray:
    """(N, 4): pixels along a mask's border, x and y, and the way out of it there, so long that opposite sides of thin
    hair are not taken for each other. height: pixels of the head."""
    border = mask & widen_mask(~mask, 1)
    border[:_EDGE] = border[-_EDGE:] = False
    border[:, :_EDGE] = border[:, -_EDGE:] = False
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), _SOFT)
    outwards = np.stack([-cv2.Sobel(soft, cv2.CV_32F, 1, 0), -cv2.Sobel(soft, cv2.CV_32F, 0, 1)], -1)[border]
    outwards = outwards / np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
    rows, columns = np.nonzero(border)
    return np.column_stack([columns, rows, _REACH * height * outwards])


def _brought(
    shell: Mesh, start: Mesh, skin: HeadSphere, camera: Camera, field: np.ndarray, net: ShellNet
) -> np.ndarray:
    """(V, 3) vertices of a shell, moved as a field (H, W, 2) of its picture says, smoothly and without folds.

    start: the shell that movements are smooth from. skin: HeadSphere of the head. net: ShellNet of the shell.
    """
    moves = _moved(shell, skin, camera, field) - start.vertices
    return net.unfolded(start.vertices + _spread(net.mean, moves, _cosines(start, camera)), skin)


def _moved(shell: Mesh, sphere: HeadSphere, camera: Camera, field: np.ndarray) -> np.ndarray:
    """(V, 3) vertices of a shell, moved as a field (H, W, 2) of its picture says.

    What faces the camera moves along the skin; what is seen from aside farther out or in, for along the skin it would
    part or be in heaps.
    """
    placed = camera.project(shell.vertices)
    move = np.column_stack([sample_pixels(field[..., k], placed[:, 0], placed[:, 1], border=0.0) for k in range(2)])
    cosine = _cosines(shell, camera)
    move *= np.interp(cosine, _BACK, (0, 1))[:, None]
    longitudes, angles, radii = sphere.seen_from(shell.vertices)
    above = radii - sphere.sample(sphere.radii, longitudes, angles)
    outwards = sphere.directions(longitudes, angles) @ camera.rotation[:2].T * camera.scale
    squares = np.maximum((outwards**2).sum(1), (_STEEPEST * camera.scale) ** 2)
    rise = np.interp(cosine, _SKIN, (1, 0)) * (move * outwards).sum(1) / squares
    move -= rise[:, None] * outwards
    longitudes, angles, _ = sphere.seen_from(shell.vertices + move / camera.scale @ camera.rotation[:2])
    return sphere.points(longitudes, angles, sphere.sample(sphere.radii, longitudes, angles) + above + rise)


def _spread(mean: sp.csr_matrix, wanted: np.ndarray, cosines: np.ndarray) -> np.ndarray:
    """(V, 3): movements that are wanted (V, 3), which go over smoothly into those of neighbours.

    Without this what is seen and what is not would part in a crease, and what is seen from aside, where a pixel is much
    of a surface, would be torn. mean: of ShellNet. cosines: (V,) between surface and view.
    """
    held = np.interp(cosines, *_HOLD)[:, None]
    still = np.interp(cosines, _BACK, (_STILL, 0))[:, None]
    moves = wanted
    for _ in range(_ROUNDS):
        moves = (held * wanted + _TOGETHER * (mean @ moves)) / (held + _TOGETHER + still)
    return moves
