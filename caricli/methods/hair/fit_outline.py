"""A star-shaped surface whose outline in a picture is that of a mask."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.structures import Camera

_BORDER = 2  # pixels: a mask that ends at the picture's border says nothing
_SECTORS = 60  # directions in each of which one point of a surface is outermost; a coarse grid has one in each
_STEPS = (0.03, 0.06)  # of the way to the outline, beyond it: there is the background


@dataclass(frozen=True, eq=False)
class Outline:
    """How far hair reaches from the projected middle of a head.

    radii: (B,) pixels, in directions ``2 pi b / B``, x to y; NaN where it is not against the background.
    """

    radii: np.ndarray

    @classmethod
    def of(cls, hair: np.ndarray, behind: np.ndarray, centre: np.ndarray, bins: int) -> "Outline":
        """hair, behind: (H, W) bool, hair and background. centre: (2,) pixels."""
        rows, columns = np.nonzero(hair)
        away = np.column_stack([columns, rows]) - centre
        radii = np.hypot(*away.T)
        number = np.floor(np.mod(np.arctan2(away[:, 1], away[:, 0]), 2 * np.pi) / (2 * np.pi) * bins).astype(int)
        farthest = np.full(bins, np.nan)
        for each in range(bins):
            chosen = number == each
            if not chosen.any():
                continue
            angle = 2 * np.pi * (each + 0.5) / bins
            most = radii[chosen].max() + 0.5
            beyond = centre + np.outer(most * (1 + np.array(_STEPS)), [np.cos(angle), np.sin(angle)])
            x, y = np.round(beyond).astype(int).T
            inside = (x >= _BORDER) & (y >= _BORDER) & (x < hair.shape[1] - _BORDER) & (y < hair.shape[0] - _BORDER)
            if inside.all() and behind[y, x].all():
                farthest[each] = most
        return cls(farthest)

    def compare(self, points: np.ndarray, centre: np.ndarray, allowed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far points (N, 2) are from the outline.

        allowed: (N,) bool, those that may be outermost. Returns (N,) shares of the way to them that the outline is at,
        NaN where it is not known, and (N,) bool, those that are outermost.
        """
        away = points - centre
        radii = np.hypot(*away.T)
        turns = np.mod(np.arctan2(away[:, 1], away[:, 0]), 2 * np.pi) / (2 * np.pi)
        share = self.radii[np.floor(turns * len(self.radii)).astype(int)] / np.maximum(radii, 1e-9)
        sector = np.floor(turns * _SECTORS).astype(int)
        order = np.lexsort([np.where(allowed, radii, -1), sector])
        outermost = np.zeros(len(points), bool)
        outermost[order[np.append(np.diff(sector[order]) > 0, True)]] = True
        return np.where(allowed, share, np.nan), outermost & allowed


def fit_outline(
    sphere: HeadSphere, camera: Camera, outline: Outline, hairy: np.ndarray, settings: ShellSettings
) -> np.ndarray:
    """Radii (R, C) of the smoothest surface around the skin whose outline is that of the hair.

    Minimises the bending of what is added to the skin, a weak pull towards the usual thickness, and the distances
    between the outlines, which are compared anew in rounds.

    hairy: (R, C) bool, directions where there may be hair. Where the skin is outside the outline, so is less than it.
    """
    skin = sphere.radii
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    height = sphere.head.height
    bending, areas = sphere.bending
    centre = camera.project(sphere.middle)
    usual = settings.usual * height
    pull = settings.faint * areas
    added = np.full(skin.shape, usual)
    most = np.full(skin.size, np.inf)
    for _ in range(settings.rounds):
        total = skin + added
        projected = camera.project(sphere.points(longitudes, angles, total)).reshape(-1, 2)
        share, outermost = outline.compare(projected, centre, hairy.ravel())
        wanted = total.ravel() * share - skin.ravel()
        # What was outside once stays inside, or front and back would take turns.
        most = np.fmin(most, np.where(share < 1, wanted, np.inf))
        target = np.where(outermost, np.fmin(wanted, most), most)
        hold = np.isfinite(target) / _SECTORS
        if not hold.any():
            break
        matrix = settings.smooth * 1e-2 * bending + sp.diags(hold + pull)
        right = pull * usual + hold * np.where(hold > 0, target, 0)
        added = Cholesky(matrix).solve(right[:, None])[:, 0].reshape(skin.shape)
    return skin + added
