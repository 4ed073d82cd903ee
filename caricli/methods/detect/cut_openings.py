"""Eyes, teeth and the inside of the mouth in a picture: what is seen between lids and lips, and is no skin."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from caricli.methods.detect.eye_liner import eye_liner
from caricli.methods.hair.colour_border import agreeing_chances, depth_inside
from caricli.methods.hair.colour_mixture import AskedColours, ColourMixture
from caricli.render.pixels.cut_window import cut_window
from caricli.render.pixels.widen_mask import widen_mask
from caricli.structures.detection import FaceFrame
from caricli.structures.parsing import Region

_KEPT = (
    *(Region.BACKGROUND, Region.BROWS, Region.NOSE, Region.EARS, Region.HAIR, Region.GLASSES, Region.HAT),
    Region.OTHER,
)
_INSIDE = (Region.MOUTH, Region.TEETH)


@dataclass(frozen=True)
class OpeningSettings:
    """How openings are told from the skin around them. Lengths are shares of the side of the face's frame.

    side: pixels, of the window that is looked at; share: its side, of the face's. beyond: how far from the border of
    what a network takes for an opening colours are asked. around: as many times as far colours of skin are learnt.
    components: Gaussians of the colours of an opening, and of what is around it; spread: added to their variances, of
    CIELAB. samples: pixels that these are fitted to; fewest: with less there is nothing to compare. rounds: of colours
    and pixels in turns. colour: natural logarithm of the odds that a colour counts at most; place: the same of the
    distance from the border, per side. radius, smoothness: of the filter that makes neighbours agree, pixels and shares
    of full scale. blur: of the picture, pixels. part: share of the largest piece of lips that another has to have to be
    one. steps: of so far, that a mouth, and whites of eyes, may be wider than their regions; gain: in area, below which
    such a step is the last. around_mouth, around_eyes: pixels of the window, around a mouth and an eye, where its
    colours are mixed with the skin's. beside: the same, around what is labelled mouth, within which lips may be
    labelled so, too. whiter: levels of 255 by which whites of eyes are lighter than skin is in the median.
    """

    side: int = 256
    share: float = 1.25
    beyond: float = 0.06
    around: float = 2.0
    components: tuple[int, int] = (4, 6)
    spread: float = 25.0
    samples: int = 3000
    fewest: int = 30
    rounds: int = 2
    colour: float = 5.0
    place: float = 80.0
    radius: int = 2
    smoothness: float = 0.05
    blur: float = 0.8
    part: float = 0.2
    steps: int = 6
    gain: float = 1.03
    around_mouth: int = 2
    around_eyes: int = 3
    beside: int = 2
    whiter: int = 10


_SETTINGS = OpeningSettings()
_UNIT = _SETTINGS.side / _SETTINGS.share


@dataclass(frozen=True, eq=False)
class FaceWindow:
    """A face, upright and always as large.

    matrix: (2, 3) map to it from the picture's pixels. picture: (S, S, 3) uint8. labels: (S, S) values of Region.
    """

    matrix: np.ndarray
    picture: np.ndarray
    labels: np.ndarray

    @staticmethod
    def of(image: np.ndarray, regions: np.ndarray, points: np.ndarray) -> "FaceWindow":
        """The window of a picture (H, W, 3) uint8 with regions (H, W), by landmarks (68 or 81, 2) pixels."""
        matrix = FaceFrame.of(points).matrix(_SETTINGS.side, _SETTINGS.share)
        size = (_SETTINGS.side, _SETTINGS.side)
        labels = cv2.warpAffine(regions, matrix, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
        return FaceWindow(matrix, cut_window(image, matrix, size), labels)

    @property
    def labelled_mouth(self) -> np.ndarray:
        """(S, S) bool: what is labelled so, and what has lips or a mouth above and below it."""
        inside = np.isin(self.labels, _INSIDE)
        own = inside | (self.labels == Region.LIPS)
        count, parts, figures, _ = cv2.connectedComponentsWithStats(own.astype(np.uint8))
        if count == 1:
            return inside
        areas = figures[1:, cv2.CC_STAT_AREA]
        large = np.isin(parts, 1 + np.flatnonzero(areas >= _SETTINGS.part * areas.max()))
        above = np.logical_or.accumulate(large, axis=0)
        below = np.logical_or.accumulate(large[::-1], axis=0)[::-1]
        return inside | (above & below & ~large)

    def eyes(self) -> np.ndarray:
        """(S, S) bool: the eyes, each with what it surrounds."""
        filled = self._grown(self.labels == Region.EYES).astype(np.uint8)
        pieces, _ = cv2.findContours(filled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for piece in pieces:
            cv2.fillConvexPoly(filled, cv2.convexHull(piece), 1)
        return self._with_whites(filled > 0)

    def _with_whites(self, eyes: np.ndarray) -> np.ndarray:
        """(S, S) bool: eyes (S, S) bool with what of their whites goes on beyond them, lighter than the skin."""
        skin = np.isin(self.labels, (Region.SKIN, Region.NOSE)) & ~eyes
        if not skin.any():
            return eyes
        light = self._lightness > np.median(self._lightness[skin]) + _SETTINGS.whiter
        return self._grown_in_steps(eyes, light)

    def liner(self, eyes: np.ndarray) -> np.ndarray:
        """(S, S) bool: ink beyond the corners of eyes (S, S) bool, see ``eye_liner``."""
        skin = np.isin(self.labels, (Region.SKIN, Region.NOSE))
        return eye_liner(self._lightness, eyes, skin, np.isin(self.labels, _KEPT) & (self.labels != Region.NOSE))

    def mouth(self, seed: np.ndarray, lips: np.ndarray | None = None) -> np.ndarray:
        """(S, S) bool: the inside of the mouth of which a seed (S, S) bool is a part.

        lips: (S, S) bool, what shows the colours of lips, which are none of its; None where nobody knows.
        """
        return self._grown_in_steps(seed, True, lips)

    def _grown_in_steps(
        self, seed: np.ndarray, within: np.ndarray | bool, other: np.ndarray | None = None
    ) -> np.ndarray:
        """(S, S) bool: a seed grown again and again within (S, S) bool, or everywhere; for the others see `_grown`."""
        for _ in range(_SETTINGS.steps):
            grown = seed | (self._grown(seed, other) & within)
            if grown.sum() < _SETTINGS.gain * seed.sum():
                return grown
            seed = grown
        return seed

    @cached_property
    def _lightness(self) -> np.ndarray:
        """(S, S) uint8, a little blurred."""
        smooth = cv2.GaussianBlur(self.picture, (0, 0), _SETTINGS.blur)
        lightness: np.ndarray = cv2.cvtColor(smooth, cv2.COLOR_RGB2LAB)[..., 0]
        return lightness

    def _grown(self, seed: np.ndarray, other: np.ndarray | None = None) -> np.ndarray:
        """(S, S) bool: what an opening is of which a seed (S, S) bool is a part, by the colours around it and by those
        of other places (S, S) bool that are none of it."""
        rows, columns = np.nonzero(seed)
        if len(rows) < _SETTINGS.fewest:
            return seed
        reach = int(_SETTINGS.around * _SETTINGS.beyond * _UNIT) + 2
        part = np.s_[
            max(rows.min() - reach, 0) : rows.max() + reach + 1,
            max(columns.min() - reach, 0) : columns.max() + reach + 1,
        ]
        kept = np.isin(self.labels[part], _KEPT) & ~seed[part]
        grown = seed.copy()
        others = np.zeros_like(kept) if other is None else other[part]
        grown[part] = _alike(np.ascontiguousarray(self.picture[part]), seed[part], kept, others)
        return grown


def cut_openings(image: np.ndarray, regions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Find the pixels that show eyes, teeth or the inside of a mouth, by regions and by colours around them.

    Regions are coarse, and of an unusual eye or grin often only a part: what is near to them, hangs together with them
    and looks as they do rather than as what is farther off belongs to them. So does what stands between lips, and what
    the rest of an eye surrounds. Ink that prolongs eyes is found besides.

    image: (H, W, 3) uint8. regions: (H, W) values of Region. points: (68 or 81, 2) pixels, landmarks of the face, all
    known. Returns (H, W) bool.
    """
    window = FaceWindow.of(image, regions, points)
    eyes = window.eyes()
    sure = widen_mask(eyes | window.liner(eyes), _SETTINGS.around_eyes)
    seed = window.labelled_mouth
    lips = (window.labels == Region.LIPS) & ~widen_mask(seed, _SETTINGS.beside)
    sure |= widen_mask(window.mouth(seed, lips), _SETTINGS.around_mouth)
    way = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    there = cv2.warpAffine(sure.astype(np.float32), window.matrix, image.shape[1::-1], flags=way)
    return (there > 0.5) | np.isin(regions, (Region.EYES, *_INSIDE))


def _alike(picture: np.ndarray, seed: np.ndarray, kept: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(h, w) bool: what looks as a seed does, near to it, in a picture (h, w, 3) uint8, but for what is kept, and for
    what looks as other places do.

    Odds are those of mixtures of Gaussians of the colours of the seed and of what is farther off, up to a bound, times
    those of the place; a guided filter (He et al. 2013) makes neighbours agree.
    """
    settings = _SETTINGS
    away = depth_inside(seed) / _UNIT
    near = away > -settings.around * settings.beyond
    smooth = cv2.GaussianBlur(picture, (0, 0), settings.blur)
    asked = AskedColours(cv2.cvtColor(smooth, cv2.COLOR_RGB2LAB).astype(np.float32))
    opening = seed
    # What is next to the seed may be of it, and says nothing of what is around it at first.
    rest = away < -settings.beyond
    for _ in range(settings.rounds):
        pixels = (opening & ~other, rest & near | other)
        if min(int(own.sum()) for own in pixels) < settings.fewest:
            return seed
        scores = [_likelihoods(asked, own, k) for own, k in zip(pixels, settings.components, strict=True)]
        odds = np.clip(scores[0] - scores[1], -settings.colour, settings.colour) + settings.place * away
        chances = agreeing_chances(picture, odds, settings.radius, settings.smoothness)
        opening = np.where(np.abs(away) > settings.beyond, seed, chances > 0.5) & ~kept
        _, parts = cv2.connectedComponents(opening.astype(np.uint8))
        opening &= np.isin(parts, parts[seed & opening])
        rest = ~opening
    return opening


def _likelihoods(asked: AskedColours, pixels: np.ndarray, count: int) -> np.ndarray:
    """(h, w) how likely colours are among pixels (h, w) bool of them."""
    colours = asked.colours[pixels]
    chosen = np.linspace(0, len(colours) - 1, min(len(colours), _SETTINGS.samples)).astype(int)
    return asked.log_likelihoods(ColourMixture(colours[chosen], count, _SETTINGS.spread))
