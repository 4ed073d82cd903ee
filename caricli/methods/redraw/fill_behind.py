"""What is behind a head, where it was hidden."""

import cv2
import numpy as np

from caricli.methods.redraw.moved_head import MovedHead

_BORDER = 0.008  # of the head's height: so far from the head the picture may show a mixture
_REACH = 4  # pixels, from which each that is filled takes its colour
_AROUND = 9  # pixels around what is needed that are filled with it
_SOLID = 0.99
_SHOWN = 0.05  # share of the head in a pixel from which on it is not what is behind


def fill_behind(head: MovedHead, picture: np.ndarray) -> np.ndarray:
    """A picture with colours from around it where the head was and is not (Telea 2004).

    picture: (H, W, 3) uint8, the old one, or what else there is in its place.
    Returns (H, W, 3) float32, samples of the window.
    """
    original = head.original
    window = original.window
    old = window.sampled(picture).astype(np.float32)
    hidden = cv2.dilate((original.head > _SHOWN).astype(np.uint8), original.disc(_BORDER)) > 0
    needed = hidden & (head.solid < _SOLID) & (head.motion > original.settings.still)
    if not needed.any():
        return old
    wanted = cv2.dilate(np.ceil(window.means(needed.astype(np.float32))), np.ones((_AROUND, _AROUND)))
    hole = (wanted > 0) & (window.means(hidden.astype(np.float32)) > 0)
    filled = cv2.inpaint(np.ascontiguousarray(window.cut(picture)), hole.astype(np.uint8), _REACH, cv2.INPAINT_TELEA)
    filled = filled.repeat(window.fine, axis=0).repeat(window.fine, axis=1)
    return np.where(needed[..., None], filled, old).astype(np.float32)
