"""Hair moved until its border in the picture is that of a mask."""

from dataclasses import replace

import cv2
import igl
import numpy as np
from scipy.ndimage import distance_transform_edt

from caricli.geometry.join_meshes import join_meshes
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_pixels
from caricli.structures import Camera, Hair, Mesh
from caricli.template.template import Template

_WIDTHS = (0.04, 0.03, 0.02, 0.015, 0.01, 0.01)  # of the head's height: over which a movement is spread, in turns
_REACH = 0.06  # of the head's height: borders farther apart than this are not of the same place
_FADING = 0.05  # of what a straight border weighs: less of it near moves less
_BACK = (-0.6, -0.2)  # cosines between surface and view, from which on and with which it moves along
_SKIN = (0.2, 0.6)  # cosines from which on and with which it stays as high above the skin
_RAMP = 4  # vertices over which a skull that is lowered leads down
_EDGE = 2  # pixels: the picture's end is no border


def snap_border(
    hair: Hair,
    head: Template,
    camera: Camera,
    mask: HairMask,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> tuple[Hair, Template]:
    """Move a shell so that what the camera sees of it ends where the mask ends, and the skull so that it is under it.

    Every pixel of either border wants to be at the nearest of the other one; what they want, averaged with weights that
    fall with the distance, moves what is near them, in smaller and smaller neighbourhoods. Where the surface faces the
    camera it goes along the skin.

    hair: Hair on the head. head: Template in the shape of the face. camera: of the picture. mask: HairMask.
    Returns Hair with the same polygons and roots, and the head.
    """
    sphere = HeadSphere(head, settings, fine=True)
    for width in _WIDTHS:
        shown = visible_hair(head, hair, camera, mask.pixels.shape)
        points = _moved(hair.shell, sphere, camera, _field(shown, mask.pixels, camera.scale * head.height, width))
        hair = replace(hair, shell=hair.shell.with_vertices(points))
        head = _sunk(head, hair.shell, sphere, settings)
    return hair, head


def _sunk(head: Template, shell: Mesh, sphere: HeadSphere, settings: ShellSettings) -> Template:
    """The head with its skull below a shell, and what is beside it leading there."""
    longitudes, angles, radii = sphere.seen_from(head.vertices)
    # The rim itself is below the skin.
    inner = shell.faces[(shell.faces < len(shell.vertices) - settings.columns).all(1)]
    least = sphere.cover(shell.vertices, inner, longitudes, angles) - settings.least * head.height
    skull = ~head.mask("ear_left", "ear_right")
    wanted = np.where(skull, np.clip(radii - least, 0, 0.5 * radii), 0)
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    lower = wanted
    for _ in range(_RAMP):
        lower = np.maximum(wanted, np.where(skull, mean @ lower, 0))
    kept = 1 - lower / np.maximum(radii, 1e-9)
    return head.with_vertices(sphere.middle + kept[:, None] * (head.vertices - sphere.middle))


def visible_hair(head: Mesh, hair: Hair, camera: Camera, shape: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: the pixels of a picture of a shape where hair is in front of the head."""
    both = join_meshes([head, hair.shell])
    raster = rasterise(camera.place(both.vertices), both.faces, shape[1], shape[0])
    return raster.face >= len(head.faces)


def _field(shown: np.ndarray, wanted: np.ndarray, height: float, width: float) -> np.ndarray:
    """(H, W, 2) pixels, x and y: how pixels move so that the border of the first mask comes to that of the second.

    height: pixels of the head. width: share of it over which movements are spread.
    """
    borders = [_border(shown), _border(wanted)]
    total = np.zeros((*shown.shape, 3), np.float32)
    for start, end, way in ((0, 1, 1), (1, 0, -1)):
        if not borders[end].any():
            continue
        nearest = distance_transform_edt(~borders[end], return_distances=False, return_indices=True)
        rows, columns = np.nonzero(borders[start])
        ends = nearest[:, rows, columns]
        move = np.column_stack([ends[1] - columns, ends[0] - rows])
        close = np.hypot(*move.T) < _REACH * height
        # It acts where the shown border is: that is the one that moves.
        at = np.stack([rows, columns]) if way > 0 else ends
        np.add.at(total, (at[0][close], at[1][close]), np.column_stack([way * move, np.ones(len(move))])[close])
    spread = max(width * height, 1.0)
    total = cv2.GaussianBlur(total, (0, 0), spread, borderType=cv2.BORDER_CONSTANT)
    usual = 2 / (np.sqrt(2 * np.pi) * spread)
    return total[..., :2] / (total[..., 2:] + _FADING * usual)


def _border(mask: np.ndarray) -> np.ndarray:
    inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1) > 0
    border = mask & ~inner
    border[:_EDGE] = border[-_EDGE:] = False
    border[:, :_EDGE] = border[:, -_EDGE:] = False
    return border


def _moved(shell: Mesh, sphere: HeadSphere, camera: Camera, field: np.ndarray) -> np.ndarray:
    """(V, 3) vertices of a shell, moved as a field (H, W, 2) of its picture says."""
    placed = camera.project(shell.vertices)
    move = np.column_stack([sample_pixels(field[..., k], placed[:, 0], placed[:, 1], border=0.0) for k in range(2)])
    # Vertices of nothing but triangles without area have no normal.
    cosine = -np.nan_to_num(igl.per_vertex_normals(shell.vertices, shell.faces)) @ camera.rotation[2]
    move = move * np.clip((cosine - _BACK[0]) / (_BACK[1] - _BACK[0]), 0, 1)[:, None]
    points = shell.vertices + move / camera.scale @ camera.rotation[:2]
    longitudes, angles, radii = sphere.seen_from(shell.vertices)
    above = radii - sphere.sample(sphere.radii, longitudes, angles)
    longitudes, angles, radii = sphere.seen_from(points)
    along = sphere.sample(sphere.radii, longitudes, angles) + above
    share = np.clip((cosine - _SKIN[0]) / (_SKIN[1] - _SKIN[0]), 0, 1)
    return sphere.points(longitudes, angles, radii + share * (along - radii))
