"""Where hair ends that no picture shows: around ears, behind them, and at the nape."""

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import KDTree

from caricli.methods.hair.hair_view import HairView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings

MOSTLY = 0.5
"""Share of an ear that shows, above which hair ends before all of it."""

_TUFTS = ((37, 0.3), (23, 1.7), (53, 2.9))  # half of how many there are around the head, and where they begin
_HOLLOW = 4  # times as far under the skin as it is inside the clearance: ears are hollow
_EVERY = 3  # rows and columns of a map: so far apart the way to the usual hairline is measured
_ROUND = 2.0  # rows and columns over which its corners are rounded
_NAPE = 0.04  # of the head's height: how much lower than at the sides hair ends behind
_FAR = 0.25  # share of an ear that the head does not hide, below which it is on its far side
_AROUND = 0.5  # radians beyond which an ear is far


def without_corners(sphere: HeadSphere, edge: np.ndarray, settings: ShellSettings) -> np.ndarray:
    """(C,) angles where hair ends, which fall nowhere more steeply than a slope: behind ears it goes down in an arc.

    edge: (C,) radians from the whorl, of every longitude of the sphere.
    """
    apart = np.abs(sphere.longitudes[:, None] - sphere.longitudes)
    apart = np.minimum(apart, 2 * np.pi - apart) * np.sin(edge)
    lowest: np.ndarray = (edge + settings.slope * apart).min(1)
    return lowest


def reach_inside(sphere: HeadSphere, inside: np.ndarray) -> np.ndarray:
    """(R, C) metres through the air to where places (R, C) bool of the skin end, below zero beyond."""
    around, down = np.meshgrid(sphere.longitudes, sphere.angles)
    points = sphere.points(around, down, sphere.radii)
    places = points[_EVERY // 2 :: _EVERY, ::_EVERY]
    inwards, outwards = (KDTree(points[side]).query(places)[0] for side in (~inside, inside))
    return sphere.sample(inwards - outwards, around, down)


def usual_reach(sphere: HeadSphere, settings: ShellSettings) -> np.ndarray:
    """(R, C) metres along the skin to where hair usually ends, in tufts, below zero beyond.

    That is the border of the scalp, from the temples down before the ears, around these and behind them to the nape,
    which is lower in the middle. It says nothing of how far hair is clear of ears.
    """
    reach = gaussian_filter(reach_inside(sphere, sphere.region("scalp") > 0.5), _ROUND, mode=("nearest", "wrap"))
    return reach + lower_nape(sphere) + _tufts(sphere, settings)


def lower_nape(sphere: HeadSphere) -> np.ndarray:
    """(C,) metres that hair ends lower behind than at the sides."""
    return _NAPE * sphere.head.height * np.clip(-np.cos(sphere.longitudes), 0, 1) ** 2


def _tufts(sphere: HeadSphere, settings: ShellSettings) -> np.ndarray:
    """(C,) metres that hair ends lower in tufts."""
    tufts = np.mean([np.abs(np.sin(count * sphere.longitudes / 2 + start)) for count, start in _TUFTS], axis=0)
    return settings.tuft * sphere.head.height * (1 - 2 * tufts)


def hidden_reach(sphere: HeadSphere, ends: np.ndarray, settings: ShellSettings) -> np.ndarray:
    """(R, C) metres along the skin to where hair ends at angles (C,), in tufts, below zero beyond."""
    turn = sphere.longitudes[1] - sphere.longitudes[0]
    # Where there is no hair, it ends at the whorl, around which no way is long.
    around = np.maximum(np.sin(ends), np.sin(turn))
    rise = (np.roll(ends, -1) - np.roll(ends, 1)) / (2 * turn) / around
    along = (ends - sphere.angles[:, None]) * sphere.radii
    return along / np.sqrt(1 + rise**2) + _tufts(sphere, settings)


def around_ears(sphere: HeadSphere, view: HairView, settings: ShellSettings) -> tuple[np.ndarray, np.ndarray]:
    """(R, C) metres to where hair is clear of an ear, below zero nearer; and (R, C) bool, where that ear mostly shows.

    Of ears that are under the hair of the picture, and beyond its border, nothing needs to be clear; of those that
    mostly show, all. An ear on the far side of the head is under hair if the other one is.
    """
    far = far_ear(sphere, view)
    ears = [_bare(ear, view) if k != far else ear[:0] for k, ear in enumerate(sphere.ears)]
    bare = np.concatenate(ears)
    if not len(bare):
        return np.full(sphere.radii.shape, sphere.head.height), np.zeros(sphere.radii.shape, bool)
    whole = [len(own) == len(ear) for own, ear in zip(ears, sphere.ears, strict=True)]
    # The last is of places that are far from any ear.
    mostly = np.append(np.repeat(whole, [len(own) for own in ears]), False)
    longitudes, angles, _ = sphere.seen_from(bare)
    places = sphere.directions(*np.meshgrid(sphere.longitudes, sphere.angles))
    tree = KDTree(sphere.directions(longitudes, angles))
    distance, nearest = tree.query(places, distance_upper_bound=_AROUND)
    free = np.minimum(distance, _AROUND) * sphere.radii - settings.clear * sphere.head.height
    return np.where(free < 0, _HOLLOW * free, free), mostly[nearest]


def far_ear(sphere: HeadSphere, view: HairView) -> int | None:
    """Which ear is on the far side of the head, if the picture shows the other one under hair; or None."""
    hidden = [view.shows(ear).mean() < _FAR for ear in sphere.ears]
    covered = [view.bare(ear).mean() <= MOSTLY for ear in sphere.ears]
    return next((k for k in (0, 1) if hidden[k] and covered[1 - k] and not hidden[1 - k]), None)


def _bare(ear: np.ndarray, view: HairView) -> np.ndarray:
    """Those of an ear's points (N, 3) that hair must not cover: strands on an ear that mostly shows would be shreds."""
    shown = view.bare(ear)
    return ear if shown.mean() > MOSTLY else ear[shown]
