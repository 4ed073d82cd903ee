"""Hair moved as pixels of its picture want to move, to bring its border to that of a mask."""

import cv2
import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.visible_hair import facing
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.render.pixels.widen_mask import widen_mask
from caricli.structures import Camera, Mesh

_REACH = 0.06  # of the head's height: borders farther apart than this are not of the same place
_FADING = 0.05  # of what a straight border weighs: less of it near moves less
_BACK = (-0.6, -0.2)  # cosines between surface and view, from which on and with which it moves along
_SKIN = (0.2, 0.6)  # cosines with which at most it moves out and in, and from which on along the skin
_STEEPEST = 0.5  # of the way out of a head, that is seen at least where hair is moved out and in
_HOLD = ((-0.6, -0.2, 0.2, 0.6), (0.0, 0.3, 0.3, 1.0))  # of cosines, how much counts what the picture says
_TOGETHER = 0.3  # weight of the neighbours' movement beside that
_STILL = 0.03  # weight of not moving, of what is behind
_ROUNDS = 10  # of bringing movements to neighbours, which reach so many edges behind what is seen
_SOFT = 1.5  # pixels over which the way out of a border is looked for
_EDGE = 2  # pixels: the picture's end is no border


def mask_border(mask: np.ndarray, height: float) -> np.ndarray:
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


def border_field(shown: np.ndarray, there: np.ndarray, height: float, width: float) -> np.ndarray:
    """(H, W, 2) pixels, x and y: how pixels move so that the border of a mask comes to another one, see `mask_border`.

    height: pixels of the head. width: share of it over which movements are spread.
    """
    here = mask_border(shown, height)
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


def follow_field(
    shell: Mesh, start: Mesh, skin: HeadSphere, camera: Camera, field: np.ndarray, net: ShellNet
) -> np.ndarray:
    """(V, 3) vertices of a shell, moved as a field (H, W, 2) of its picture says, smoothly and without folds.

    start: the shell that movements are smooth from. skin: HeadSphere of the head. net: ShellNet of the shell.
    """
    moves = _moved(shell, skin, camera, field) - start.vertices
    return net.unfolded(start.vertices + _spread(net.mean, moves, facing(start, camera)), skin)


def _moved(shell: Mesh, sphere: HeadSphere, camera: Camera, field: np.ndarray) -> np.ndarray:
    """(V, 3) vertices of a shell, moved as a field (H, W, 2) of its picture says.

    What faces the camera moves along the skin; what is seen from aside farther out or in, for along the skin it would
    part or be in heaps.
    """
    placed = camera.project(shell.vertices)
    move = np.column_stack([sample_pixels(field[..., k], placed[:, 0], placed[:, 1], border=0.0) for k in range(2)])
    cosine = facing(shell, camera)
    move *= np.interp(cosine, _BACK, (0, 1))[:, None]
    longitudes, angles, radii = sphere.seen_from(shell.vertices)
    above = radii - sphere.ground(longitudes, angles)
    outwards = sphere.directions(longitudes, angles) @ camera.rotation[:2].T * camera.scale
    squares = np.maximum((outwards**2).sum(1), (_STEEPEST * camera.scale) ** 2)
    rise = np.interp(cosine, _SKIN, (1, 0)) * (move * outwards).sum(1) / squares
    move -= rise[:, None] * outwards
    longitudes, angles, _ = sphere.seen_from(shell.vertices + move / camera.scale @ camera.rotation[:2])
    return sphere.points(longitudes, angles, sphere.ground(longitudes, angles) + above + rise)


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
