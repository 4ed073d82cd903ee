"""A star-shaped surface whose outline in a picture is that of a mask."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solveh_banded

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera

_BORDER = 2  # pixels: a mask that ends at the picture's border says nothing
_ARC = 0.25  # of a turn: so much of an outline, at most, goes on round beyond the picture
_SECTORS = 60  # directions in each of which one point of a surface is outermost; a coarse grid has one in each
_TURNS = 3  # of meeting the outline
_STEEP = 8  # power of the share of the way to the outline with which what is inside follows
_SETTLED = 1e-6  # of the head's height, by which a surface changes where another round changes nothing
_STEPS = (0.03, 0.06)  # of the way to the outline, beyond it: there is the background


@dataclass(frozen=True, eq=False)
class Outline:
    """How far hair reaches from the projected middle of a head.

    centre: (2,) pixels, that middle.
    radii: (B,) pixels, in directions ``2 pi b / B``, x to y; NaN where it is not against the background.
    limits: (B,) pixels, how far it may reach at most where no hair is seen: as far as the head, where this is against
    the background, and NaN elsewhere.
    """

    centre: np.ndarray
    radii: np.ndarray
    limits: np.ndarray

    @classmethod
    def of(cls, hair: HairMask, sphere: HeadSphere, camera: Camera, bins: int) -> "Outline":
        """hair: HairMask around a head, whose directions sphere has. bins: B."""
        rows, columns = hair.pixels.shape
        head = sphere.head
        centre = camera.project(sphere.middle)
        shown = rasterise(camera.place(head.vertices), head.faces, columns, rows).face >= 0
        radii = _farthest(hair.pixels, hair.behind, centre, bins)
        return cls(centre, radii, np.where(np.isnan(radii), _farthest(shown, hair.behind, centre, bins), np.nan))

    def bald(self, shape: tuple[int, int]) -> np.ndarray:
        """(H, W) bool: pixels of a picture in directions in which no hair reaches beyond the head."""
        y, x = np.indices(shape)
        return np.isfinite(self.limits)[_directions(np.stack([x, y], -1) - self.centre, len(self.limits))]

    def compare(self, points: np.ndarray, allowed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far points (N, 2) are from the outline.

        allowed: (N,) bool, those that may be outermost. Returns (N,) shares of the way to them that the outline is at,
        NaN where it is not known, and (N,) bool, those that are outermost.
        """
        away = points - self.centre
        radii = np.hypot(*away.T)
        number = _directions(away, len(self.radii))
        limited = np.isfinite(self.limits)[number]
        share = np.where(limited, self.limits[number], self.radii[number]) / np.maximum(radii, 1e-9)
        sector = _directions(away, _SECTORS)
        order = np.lexsort([np.where(allowed, radii, -1), sector])
        outermost = np.zeros(len(points), bool)
        outermost[order[np.append(np.diff(sector[order]) > 0, True)]] = True
        return np.where(allowed, share, np.nan), outermost & allowed & ~limited


def meet_outline(
    sphere: HeadSphere, camera: Camera, outline: Outline, hairy: np.ndarray, total: np.ndarray
) -> np.ndarray:
    """Radii (R, C) with which a surface of radii (R, C) meets an outline exactly, where `fit_outline` is smooth.

    Seen from the camera radii go along directions from the projected middle, so that what is outermost in a direction
    is brought to the outline by a factor, and what is nearer to the middle follows less.

    hairy: (R, C) bool, directions that may be outermost.
    """
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    bins = len(outline.radii)
    for _ in range(_TURNS):
        away = camera.project(sphere.points(longitudes, angles, total)).reshape(-1, 2) - outline.centre
        radii = np.hypot(*away.T)
        number = _directions(away, bins)
        outermost = np.zeros(bins)
        chosen = hairy.ravel()
        np.maximum.at(outermost, number[chosen], radii[chosen])
        outermost = np.where(outermost > 0, outermost, np.inf)
        factors = np.where(np.isnan(outline.radii), np.fmin(outline.limits / outermost, 1), outline.radii / outermost)
        factors = _filled(np.where(np.isinf(outermost), np.nan, factors))
        place = np.arctan2(away[:, 1], away[:, 0]) / (2 * np.pi) * bins - 0.5
        factor = np.interp(place, np.arange(bins), factors, period=bins)
        nearness = np.clip(radii / outermost[number], 0, 1) ** _STEEP
        total = total * (1 + nearness * (factor - 1)).reshape(total.shape)
    return total


def _directions(away: np.ndarray, count: int) -> np.ndarray:
    """(...) int from 0 to count - 1: in which of so many directions, clockwise from the right, ways (..., 2) go."""
    turns = np.arctan2(away[..., 1], away[..., 0]) / (2 * np.pi)
    # What is a rounding error before the right is a whole turn after it.
    return np.floor(np.mod(turns, 1.0) * count).astype(int) % count


def _filled(factors: np.ndarray) -> np.ndarray:
    """Factors (B,) around a circle, those that are not known between their neighbours'; one where none is."""
    given = np.flatnonzero(np.isfinite(factors))
    if len(given) == 0:
        return np.ones_like(factors)
    return np.interp(np.arange(len(factors)), given, factors[given], period=len(factors))


def _farthest(mask: np.ndarray, behind: np.ndarray, centre: np.ndarray, bins: int) -> np.ndarray:
    """(bins,) pixels, how far a mask (H, W) reaches in each direction, NaN where no background (H, W) is beyond it."""
    rows, columns = np.nonzero(mask)
    away = np.column_stack([columns, rows]) - centre
    number = _directions(away, bins)
    farthest = np.full(bins, -np.inf)
    np.maximum.at(farthest, number, np.hypot(*away.T) + 0.5)
    turns = 2 * np.pi * (np.arange(bins) + 0.5) / bins
    reach = np.where(np.isfinite(farthest), farthest, 0)[:, None] * (1 + np.array([0, *_STEPS]))
    x, y = (
        np.round(centre[k] + reach * way[:, None]).astype(int) for k, way in enumerate((np.cos(turns), np.sin(turns)))
    )
    height, width = mask.shape
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    against = behind[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] | ~inside
    # What reaches the picture's border goes on beyond it.
    whole = inside[:, 0] & (x[:, 0] >= _BORDER) & (y[:, 0] >= _BORDER)
    whole &= (x[:, 0] < width - _BORDER) & (y[:, 0] < height - _BORDER)
    radii = np.where(np.isfinite(farthest) & whole & against[:, 1:].all(1), farthest, np.nan)
    return _rounded(radii, np.isfinite(farthest) & ~whole)


def _rounded(radii: np.ndarray, cut: np.ndarray) -> np.ndarray:
    """Radii (B,) with an arc between both ends of what the picture's border cuts off (B,) bool, where this is short."""
    bins = len(radii)
    given = np.flatnonzero(np.isfinite(radii))
    if len(given) < 2:
        return radii
    place = np.searchsorted(given, np.arange(bins))
    before = given[place - 1] - bins * (place == 0)
    after = given[place % len(given)] + bins * (place == len(given))
    short = cut & (after - before <= _ARC * bins)
    return np.where(short, np.interp(np.arange(bins), given, radii[given], period=bins), radii)


def fit_outline(
    sphere: HeadSphere, camera: Camera, outline: Outline, hairy: np.ndarray, settings: ShellSettings
) -> np.ndarray:
    """Radii (R, C) of the smoothest surface around the skin whose outline is that of the hair.

    Minimises the bending of what is added to the skin, a weak pull towards the usual thickness, and the distances
    between the outlines, which are compared anew in rounds, until nothing changes.

    hairy: (R, C) bool, directions where there may be hair. Where the skin is outside the outline, so is less than it.
    """
    skin = sphere.radii
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    height = sphere.head.height
    bending, areas = sphere.bending
    usual = settings.usual * height
    pull = settings.faint * areas
    added = np.full(skin.shape, usual)
    most = np.full(skin.size, np.inf)
    for _ in range(settings.rounds):
        total = skin + added
        projected = camera.project(sphere.points(longitudes, angles, total)).reshape(-1, 2)
        share, outermost = outline.compare(projected, hairy.ravel())
        wanted = total.ravel() * share - skin.ravel()
        # What was outside once stays inside, or front and back would take turns.
        most = np.fmin(most, np.where(share < 1, wanted, np.inf))
        target = np.where(outermost, np.fmin(wanted, most), most)
        hold = np.isfinite(target) / _SECTORS
        if not hold.any():
            break
        matrix = settings.smooth * 1e-2 * bending
        matrix[-1] += hold + pull
        right = pull * usual + hold * np.where(hold > 0, target, 0)
        before = added
        added = solveh_banded(matrix, right, overwrite_ab=True, check_finite=False).reshape(skin.shape)
        if np.abs(added - before).max() < _SETTLED * height:
            break
    return skin + added
