"""The picture on a shell of hair."""

import cv2
import numpy as np
import scipy.sparse as sp

from caricli.methods.hair.continue_strands import continue_strands
from caricli.methods.hair.make_shell import DISC, unrolled_to_uv
from caricli.methods.texture.picture_view import PictureView, SeenColours, SurfacePoints
from caricli.render.smooth_normals import smooth_normals
from caricli.render.uv_map import pad_texture, uv_map
from caricli.structures import Hair

_STRANGE = 3.5  # of the median distance from the median colour
_NEVER_STRANGE = 6.0  # CIELAB
_ROWS = 192
_COLUMNS = 640


def paint_hair(hair: Hair, view: PictureView, size: int, generator: np.random.Generator) -> np.ndarray:
    """Paint a shell with the picture where the picture shows it, and with strands continued from there elsewhere.

    Strands are continued in the picture of the shell unrolled around its whorl, where they run down from it, the edge
    in the last row: `continue_strands`; what the other side shows comes first.

    hair: Hair of `make_shell`. view: PictureView of its shell. size: texels. generator: of the choice of strips.
    Returns (size, size, 3) uint8.
    """
    settings = view.settings
    own = _look(hair, view, size)
    other = SeenColours(own.colours[:, ::-1], own.seen[:, ::-1])
    both = own.completed(other, settings.mirrored)
    x, y = _unrolled(size)
    colours = cv2.remap(both.colours.astype(np.float32), x, y, cv2.INTER_LINEAR)
    seen = cv2.remap(both.seen.astype(np.float32), x, y, cv2.INTER_LINEAR) > settings.trust
    seen &= _usual(colours, seen)
    filled = continue_strands(colours, seen, generator).astype(np.float32)
    column, row = _rolled(size)
    elsewhere = cv2.remap(np.pad(filled, ((0, 0), (1, 1), (0, 0)), mode="wrap"), column + 1, row, cv2.INTER_LINEAR)
    trust = np.clip(both.seen / settings.trust, 0, 1)[..., None]
    trust = trust * trust * (3 - 2 * trust)
    return np.clip(np.round(trust * both.colours + (1 - trust) * elsewhere), 0, 255).astype(np.uint8)


def _look(hair: Hair, view: PictureView, size: int) -> SeenColours:
    """What the picture shows of the texels: colours (size, size, 3), seen (size, size)."""
    shell = hair.shell
    face, weights = uv_map(shell, size)
    covered = face >= 0
    corners = shell.faces[face[covered]]
    blend = weights[covered].astype(np.float64)
    normals = smooth_normals(shell.vertices, shell.faces)
    ends = np.arange(0, corners.size + 1, 3)
    mix = sp.csr_matrix((blend.ravel(), corners.ravel(), ends), (len(corners), len(normals)))
    points = mix @ shell.vertices
    normals = mix @ normals
    looked = view.look(SurfacePoints(points, normals, np.zeros(len(points))))
    colours = np.zeros((size, size, 3))
    colours[covered] = looked.colours
    seen = np.zeros((size, size))
    seen[covered] = looked.seen
    return SeenColours(pad_texture(colours, covered), pad_texture(seen, covered))


def _usual(colours: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Which of colours (R, C, 3) are like most that are seen (R, C): skin at the border of hair is not continued."""
    if not seen.any():
        return seen
    lab = cv2.cvtColor(colours / np.float32(255), cv2.COLOR_RGB2LAB)
    away = np.linalg.norm(lab - np.median(lab[seen], axis=0), axis=-1)
    return away <= _STRANGE * np.median(away[seen]) + _NEVER_STRANGE


def _unrolled(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Texels (x, y), (_ROWS, _COLUMNS) each, that the unrolled picture shows."""
    shares, turns = np.meshgrid((np.arange(_ROWS) + 0.5) / _ROWS, _turns(), indexing="ij")
    uvs = unrolled_to_uv(turns, shares)
    return (uvs[..., 0] * size - 0.5).astype(np.float32), ((1 - uvs[..., 1]) * size - 0.5).astype(np.float32)


def _rolled(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows (size, size) of the unrolled picture that texels show."""
    y, x = (np.mgrid[:size, :size] + 0.5) / size - 0.5
    column = np.mod(np.arctan2(x, y), 2 * np.pi) / (2 * np.pi) * _COLUMNS - 0.5
    row = np.hypot(x, y) / DISC * _ROWS - 0.5
    return column.astype(np.float32), np.clip(row, 0, _ROWS - 1).astype(np.float32)


def _turns() -> np.ndarray:
    return 2 * np.pi * (np.arange(_COLUMNS) + 0.5) / _COLUMNS
