"""Hair on the far side of a head that is turned."""

import numpy as np
from scipy.ndimage import gaussian_filter, grey_closing, maximum_filter

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.structures import Camera

_TURNED = (0.42, 0.57)  # sines from which on a head is turned, and with which wholly: then one side of it is seen
_AWAY = ((-0.6, -0.2), (1.0, 0.0))  # cosines between hair and view, how far what is nearer hides it
_EDGE_ON = ((0.1, 0.4), (1.0, 0.0))  # the same, how far hair is between both sides
_BETWEEN = (1, 41)  # rows and columns over which it is filled there
_SOFT = 3  # places over which what is on one side goes over into what is on the other


def as_other_side(
    sphere: HeadSphere, camera: Camera, left: np.ndarray, total: np.ndarray, hidden: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far it is to where hair ends, and how far out it is, (R, C) metres each, on the far side as on the near one.

    Of a head that is turned a picture shows one side; where both are seen alike nothing changes.

    sphere: HeadSphere of the head. camera: of the picture. left, total: (R, C) metres, what they are by the picture
    alone. hidden: (R, C) from 0 to 1, how far the head hides them.
    """
    turned = np.interp(abs(camera.rotation[2, 0]), _TURNED, (0, 1))
    other = -np.arange(left.shape[1])
    facing = facing_of(sphere.points(*np.meshgrid(sphere.longitudes, sphere.angles), total), camera)
    # What the head does not hide of it hangs behind the hair of the near side.
    unseen = np.maximum(hidden, np.interp(facing, *_AWAY))
    share = turned * inside_softly(np.maximum(unseen - unseen[:, other], 0))
    above = total - sphere.radii
    left = left + share * (left[:, other] - left)
    between = (1 - share) * maximum_filter(share, _BETWEEN, mode="wrap") * np.interp(facing, *_EDGE_ON)
    left = left + between * (grey_closing(left, _BETWEEN, mode="wrap") - left)
    return left, total + share * (above[:, other] - above)


def facing_of(points: np.ndarray, camera: Camera) -> np.ndarray:
    """(R, C) cosine between a surface (R, C, 3) and the view."""
    around = np.roll(points, -1, 1) - np.roll(points, 1, 1)
    along = np.gradient(points, axis=0)
    normals = np.cross(along, around)
    lengths = np.maximum(np.linalg.norm(normals, axis=-1), 1e-12)
    return -(normals @ camera.rotation[2]) / lengths


def inside_softly(shares: np.ndarray) -> np.ndarray:
    """Shares (R, C) from 0 to 1 that fall softly to nothing where they end, and not beyond."""
    return np.clip(2 * gaussian_filter(np.asarray(shares, float), _SOFT, mode=("nearest", "wrap")) - 1, 0, 1)
