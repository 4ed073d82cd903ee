"""What every expression of a rig does to the picture of its skin, in one picture that a shader mixes by weights."""

import cv2
import numpy as np

from caricli.data.expressions import named_expressions
from caricli.methods.dynamic.rig_moods import MoodPainter
from caricli.structures.arkit import ARKIT_NAMES, arkit_name, uses
from caricli.structures.change_atlas import NOTHING, ChangeAtlas

LARGEST = 2048
"""Texels of an atlas, width and height, at most: what every engine takes."""

_NONE = 1e-3
"""Range below which all gains or offsets count as nothing."""


def change_atlas(painter: MoodPainter) -> ChangeAtlas:
    """The changes of a rig's picture, linear in the weights.

    ``T' = T + C_0 + sum_k w_k D_k``: C_0 is what the network changes at rest, which takes out what the picture shows;
    D minimises ``sum_s |C_0 + sum_k w_sk D_k - C(w_s)|^2`` over every expression in use and, where they are ARKit's
    actions, the named ones of them, because the network says less of several at once than of each.

    painter: MoodPainter of the rig. Returns ChangeAtlas, a square of a power of two, at most LARGEST, which fades at
    the border of the face.
    """
    shown = _shown_weights(painter.names)
    count = 2 * (len(painter.names) + 1)
    columns = int(np.ceil(np.sqrt(count)))
    # A power of two, as some engines want it.
    size = min(2 ** round(np.log2(columns * painter.model.size)), LARGEST)
    side = min(painter.model.size, size // columns)
    rest = _change(painter, np.zeros(len(painter.names)), side)
    moved = np.stack([_change(painter, weights, side) - rest for weights in shown])
    parts = np.tensordot(np.linalg.pinv(shown).astype(np.float32), moved, 1)
    changes = np.concatenate([rest[None], parts])
    ranges = [max(float(np.abs(changes[:, kind]).max()), _NONE) for kind in (0, 1)]
    tiles = np.full((columns**2, side, side, 3), NOTHING, np.uint8)
    for kind, most in enumerate(ranges):
        tiles[kind:count:2] = np.rint(NOTHING + (255 - NOTHING) * changes[:, kind] / most)
    laid = tiles.reshape(columns, columns, side, side, 3).swapaxes(1, 2).reshape(columns * side, -1, 3)
    picture = np.full((size, size, 3), NOTHING, np.uint8)
    picture[: len(laid), : len(laid)] = laid
    whole = len(painter.texture.picture)
    rows, places = painter.texture.window
    window = (places.start / whole, rows.start / whole, places.stop / whole, rows.stop / whole)
    return ChangeAtlas(picture, columns, side, window, *ranges)


def _shown_weights(names: tuple[str, ...]) -> np.ndarray:
    """(N, K) weights at which the network is asked."""
    together = uses(names)
    actions = [arkit_name(name) for name in names]
    if not set(ARKIT_NAMES) <= set(actions):
        return together
    usual = [weights for weights in named_expressions(ARKIT_NAMES).values() if weights]
    return np.concatenate([together, [[weights.get(action or "", 0.0) for action in actions] for weights in usual]])


def _change(painter: MoodPainter, weights: np.ndarray, side: int) -> np.ndarray:
    """(2, S, S, 3) float32 gain and offset in the window of a picture."""
    change = painter.texture.spread(painter.change(weights))
    return np.stack([cv2.resize(values, (side, side), interpolation=cv2.INTER_AREA) for values in change])
