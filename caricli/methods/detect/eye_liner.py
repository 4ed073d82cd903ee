"""What is drawn in ink beyond the corners of an eye."""

import cv2
import numpy as np

from caricli.render.pixels.distance_to import exact_distance_to

_BEYOND = 0.4  # of the eye's width, how far from its corners ink may reach, and
_BEFORE = 0.12  # how far before them it may begin;
_BESIDE = 0.35  # how far from the eye's long axis
_AROUND = 0.6  # of its width, around it, skin is what ink is darker than
_DARK = 0.62  # of the lightness of skin, that ink has at most
_TOUCH = 2  # pixels, from the eye to its ink
_RIM = 1.5  # pixels, the border of where it may be
_SMALLEST = 40  # pixels of an eye that has corners


def eye_liner(lightness: np.ndarray, eyes: np.ndarray, skin: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Find ink that prolongs eyes beyond their corners: dark, next to an eye, and at an end where it is looked for.

    A head's own eyes end at their corners and have lashes, so that ink would stand beside them. What goes on beyond, as
    folds of skin do, is none.

    lightness: (S, S) of a picture of a face that is upright. eyes, skin, kept: (S, S) bool: pixels of eyes, of skin,
    and what is not asked. Returns (S, S) bool.
    """
    ink = np.zeros(eyes.shape, bool)
    count, parts = cv2.connectedComponents(eyes.astype(np.uint8))
    for number in range(1, count):
        eye = parts == number
        if eye.sum() >= _SMALLEST:
            ink |= _of_eye(lightness, eye, skin, kept | eyes)
    return ink


def _of_eye(lightness: np.ndarray, eye: np.ndarray, skin: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """(S, S) bool, ink of one eye."""
    places = np.stack(np.nonzero(eye), axis=1).astype(float)
    middle = places.mean(0)
    _, axes = np.linalg.eigh(np.cov(places.T))
    beside, along = np.moveaxis((np.indices(eye.shape).transpose(1, 2, 0) - middle) @ axes, 2, 0)
    width = np.ptp(along[eye])
    away = exact_distance_to(eye)
    around = skin & ~kept & (away < _AROUND * width)
    if not around.any():
        return np.zeros(eye.shape, bool)
    dark = (lightness < _DARK * np.median(lightness[around])) & ~kept
    ink = np.zeros(eye.shape, bool)
    for beyond in (along - along[eye].max(), along[eye].min() - along):
        room = np.minimum(_BEYOND * width - beyond, _BESIDE * width - np.abs(beside))
        near = dark & (beyond > -_BEFORE * width) & (room > 0)
        _, pieces = cv2.connectedComponents(near.astype(np.uint8))
        going_on = pieces[near & (room < _RIM)]
        ink |= near & np.isin(pieces, pieces[near & (away <= _TOUCH)]) & ~np.isin(pieces, going_on)
    return ink
