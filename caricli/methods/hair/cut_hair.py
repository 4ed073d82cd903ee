"""The border of hair where a picture has it, near to where a network says that it is."""

import cv2
import numpy as np

from caricli.methods.hair.colour_border import agreeing_chances, depth_inside
from caricli.methods.hair.colour_mixture import AskedColours, ColourMixture
from caricli.methods.hair.settings import MaskSettings

_COMPONENTS = 5  # Gaussians of the colours of hair, and of what is around it
_ROUNDS = 2  # of colours and probabilities in turns
_AROUND = 2  # times as far as colours are asked, they are learnt
_FEWEST = 50  # pixels that a colour model takes


def cut_hair(image: np.ndarray, hair: np.ndarray, size: float, settings: MaskSettings) -> np.ndarray:
    """Tell by its colours where hair ends, starting from a mask whose border is a few pixels off.

    A pixel's odds are those of its colour, by mixtures of Gaussians of what is hair and what is around it, up to a
    bound, times those of its place, which grow with the distance from the mask's border: so dark hair before a dark
    wall ends where the mask does. A guided filter (He et al. 2013) makes neighbours agree.

    image: (H, W, 3) uint8. hair: (H, W) bool, some of it. size: pixels, of the face. settings: MaskSettings.
    Returns (H, W) from 0 to 1, how probably each pixel shows hair; what was given where there is too little to compare.
    """
    rows, columns = np.nonzero(hair)
    around = int(_AROUND * settings.beyond * size) + 2
    part = np.s_[
        max(rows.min() - around, 0) : rows.max() + around + 1,
        max(columns.min() - around, 0) : columns.max() + around + 1,
    ]
    picture = image[part]
    zoom = min(1.0, settings.side / max(picture.shape[:2]))
    small = cv2.resize(picture, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA) if zoom < 1 else picture
    given = cv2.resize(hair[part].astype(np.uint8), small.shape[1::-1], interpolation=cv2.INTER_AREA) > 0
    probable = _probabilities(small, given, zoom * size, settings)
    whole = np.zeros(hair.shape, np.float32)
    whole[part] = cv2.resize(probable, picture.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return whole


def _probabilities(picture: np.ndarray, hair: np.ndarray, size: float, settings: MaskSettings) -> np.ndarray:
    """(H, W) from 0 to 1, how probably a pixel shows hair, by its colour and a mask (H, W) whose face has a size."""
    away = depth_inside(hair) / size
    smooth = cv2.GaussianBlur(picture, (0, 0), max(0.5, 0.004 * size))
    lab = cv2.cvtColor(smooth, cv2.COLOR_RGB2LAB).astype(np.float32)
    asked = AskedColours(lab)
    generator = np.random.RandomState(0)
    near = away > -_AROUND * settings.beyond
    probable: np.ndarray = hair.astype(np.float32)
    for _ in range(_ROUNDS):
        scores = []
        for pixels in (probable > 0.5, (probable <= 0.5) & near):
            colours = lab[pixels]
            if len(colours) < _FEWEST:
                return hair.astype(np.float32)
            chosen = generator.permutation(len(colours))[: settings.samples]
            scores.append(asked.log_likelihoods(ColourMixture(colours[chosen], _COMPONENTS, settings.spread)))
        odds = np.clip(scores[0] - scores[1], -settings.colour, settings.colour) + settings.place * away
        probable = agreeing_chances(picture, odds, max(2, int(settings.nearby * size)), settings.alike)
        probable = np.where(np.abs(away) > settings.beyond, hair, np.clip(probable, 0, 1)).astype(np.float32)
    return probable
