"""The light on a face, from the colours of its skin: nine spherical harmonics of the normals."""

from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from caricli.geometry.weighted_medians import weighted_medians
from caricli.render.sky import sphere_directions
from caricli.render.smooth_normals import even_normals

GAMMA = 2.2
"""Exponent from sRGB to linear light, near enough for ratios."""

_LEVEL = 1e-6
_LAMP = (2 / np.sqrt(3), np.sqrt(5) / 4)
"""Lengths of the first and the second order of a single far lamp in the dark, for its constant term of one: no light
has more."""

_DOME = 400


@dataclass(frozen=True)
class LightSettings:
    """How light is told from colours.

    spread: of the coefficients of the first and the second order, standard deviations for that of the constant one.
    noise: standard deviation of the skin's own colour, of logarithms. outlier: in units of the residuals' spread, from
    where on a colour counts as another thing than skin. weights: of the spread against the mean square of the
    logarithms, of which that is taken that foretells left-out parts best. tint: weight, against the same, of how far
    channels are from their mean, in that spread: lamps have colours, but not opposite ones. halvings: into these parts.
    gain: share of the left-out error that light has to explain before it is believed in. rounds: of reweighting. range:
    least and greatest light, of the mean one. least: points of skin, with fewer nothing is told. brightest: mean light
    on the skin that is seen, at most: none of 150 generated heads in random light has more, but drawings whose outlines
    are dark look as if lit from before them.
    """

    spread: tuple[float, float] = (0.5, 0.25)
    noise: float = 0.1
    outlier: float = 2.5
    weights: tuple[float, ...] = (1e-4, 1e-3, 1e-2, 1e-1)
    tint: float = 0.01
    halvings: int = 3
    gain: float = 0.1
    rounds: int = 12
    range: tuple[float, float] = (0.3, 2.5)
    least: int = 60
    brightest: float = 1.3


@dataclass(frozen=True, eq=False)
class Light:
    """Light on a surface by its normals, one for the mean of all that a camera can see.

    coefficients: (9, 3) of `harmonics`, for red, green and blue, linear light.
    range: (2, 3) least and greatest that it is taken for.
    explained: share of the variation of the skin's colours that it foretells where these were left out, from 0 to 1.
    """

    coefficients: np.ndarray
    range: np.ndarray
    explained: float

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        return {
            "harmonics": self.coefficients.round(5).tolist(),
            "least": self.range[0].round(5).tolist(),
            "greatest": self.range[1].round(5).tolist(),
            "gamma": GAMMA,
            "explained": self.explained,
        }

    def shade(self, normals: np.ndarray) -> np.ndarray:
        """(N, 3) factors of sRGB with which unlit colours come to light. normals: (N, 3) unit length."""
        return np.clip(harmonics(normals) @ self.coefficients, *self.range) ** (1 / GAMMA)

    def shade_mesh(self, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """The same factors (V, 3) for the vertices (V, 3) of a mesh with faces (F, 3)."""
        return self.shade(even_normals(vertices, faces))


def harmonics(normals: np.ndarray) -> np.ndarray:
    """(N, 9) real spherical harmonics of unit normals (N, 3), up to the second order."""
    x, y, z = normals.T
    first = np.sqrt(3 / (4 * np.pi))
    second = np.sqrt(15 / (4 * np.pi))
    one = np.full(len(normals), np.sqrt(1 / (4 * np.pi)))
    squares = [second * x * y, second * y * z, np.sqrt(5 / (16 * np.pi)) * (3 * z * z - 1)]
    return np.stack([one, first * x, first * y, first * z, *squares, second * x * z, second / 2 * (x * x - y * y)], 1)


def estimate_light(
    colours: np.ndarray, normals: np.ndarray, places: np.ndarray, weights: np.ndarray, view: np.ndarray
) -> Light | None:
    """Find the light that makes one colour of skin look as it does (Ramamoorthi and Hanrahan 2001, nine coefficients).

    Minimises sum_i w_i rho(log c_i - log(H_i l)) + weight * |l / spread|^2 for every channel, rho bounded, so that
    hair, brows and beard hardly count. What light explains is measured on parts of the face that were left out; where
    that is little, as on flat drawings, there is none.

    colours: (N, 3) sRGB, 0 to 255. normals: (N, 3) unit length. places: (N, 3) metres. weights: (N,) how much each is
    skin that is seen. view: (3,) unit, the way to the camera.
    Returns Light, or None where it explains too little, or nothing differs that it could explain.
    """
    settings = LightSettings()
    used = weights > 0
    if used.sum() < settings.least:
        return None
    logs = GAMMA * np.log(np.clip(colours[used], 1, 255) / 255)
    fit = _Fit(harmonics(normals[used]), logs, weights[used] / weights[used].sum(), settings)
    folds = _folds(places[used], weights[used], settings.halvings)
    constant = fit.missed(folds, np.inf)
    if constant <= _LEVEL:  # one colour all over: of nothing, any light explains all
        return None
    lights = [(fit.missed(folds, weight), fit.solve(np.ones(len(logs)), weight)) for weight in settings.weights]
    missed, light = min((each for each in lights if _of_lamps(each[1])), key=itemgetter(0), default=(constant, None))
    explained = 1 - missed / constant
    if light is None or explained < settings.gain:
        return None
    dome = sphere_directions(_DOME)
    # An incident light meter beside the face would say one.
    light = light / np.maximum(harmonics(dome[dome @ view > 0]) @ light, _LEVEL).mean(0)
    lit = harmonics(normals[used]) @ light
    dimmed = min(settings.brightest / max(float(np.average(lit, 0, weights[used]).mean()), _LEVEL), 1.0)
    light, lit = light * dimmed, lit * dimmed
    return Light(light, np.clip(np.quantile(lit, [0.01, 0.99], axis=0), *settings.range), float(explained))


def _of_lamps(light: np.ndarray) -> bool:
    """Whether there can be such light, (9, 3) coefficients: it is nowhere less than none."""
    orders = np.linalg.norm(light[1:4], axis=0), np.linalg.norm(light[4:], axis=0)
    return all((order <= most * light[0]).all() for order, most in zip(orders, _LAMP, strict=True))


class _Fit:
    """Skin in light: harmonics (N, 9), logarithms (N, 3) of colours, weights (N,)."""

    def __init__(self, basis: np.ndarray, logs: np.ndarray, weights: np.ndarray, settings: LightSettings) -> None:
        self.basis = basis
        self.logs = logs
        self.weights = weights
        self.settings = settings
        stiff = np.diag(np.repeat([0.0, *(1 / spread**2 for spread in settings.spread)], [1, 3, 5]))
        mean = np.full((3, 3), 1 / 3)
        self.common, self.apart = (np.einsum("cd,ij->cidj", each, stiff) for each in (mean, np.eye(3) - mean))

    def solve(self, kept: np.ndarray, weight: float) -> np.ndarray:
        """(9, 3) coefficients by points that are kept, (N,) 0 or 1; of a weight of their spread, inf for no light."""
        weights = self.weights * kept
        middle = np.exp(weighted_medians(self.logs, weights))
        light = np.zeros((9, 3))
        light[0] = middle / self.basis[0, 0]
        size = 1 if np.isinf(weight) else 9
        basis = self.basis[:, :size]
        for _ in range(self.settings.rounds):
            lit = np.maximum(self.basis @ light, 0.1 * middle)
            rest = self.logs - np.log(lit)
            robust = weights * self.trust(rest, weights)
            # Of every channel in units of its own constant term.
            slopes = light[0] / lit
            stiff = np.zeros((3, 1, 3, 1)) if size == 1 else robust.sum() * self.stiff(weight)
            left = stiff + np.einsum("ij,cd->cidj", _LEVEL**2 * np.eye(size), np.eye(3))
            for channel, slope in enumerate(slopes.T):
                left[channel, :, channel] += (robust * slope**2 * basis.T) @ basis
            right = (robust[:, None] * rest * slopes).T @ basis
            right -= np.einsum("cidj,jd->ci", stiff, light[:size] / light[0])
            step = np.linalg.solve(left.reshape(3 * size, -1), right.ravel()).reshape(3, size)
            light[:size] += step.T * light[0]
        return light

    def stiff(self, weight: float) -> np.ndarray:
        """(3, 9, 3, 9) how light is held, by channels and coefficients: near to none, and channels to each other."""
        return weight * self.common + max(weight, self.settings.tint) * self.apart

    def trust(self, rest: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(N,) from 0 to 1, how much residuals (N, 3) are those of skin."""
        size = np.sqrt((rest**2).mean(1))
        spread = max(1.4826 * float(weighted_medians(size[:, None], weights)[0]), self.settings.noise)
        return 1 / (1 + (size / (self.settings.outlier * spread)) ** 2) ** 2

    def missed(self, folds: np.ndarray, weight: float) -> float:
        """Bounded squares of the residuals of points that were left out."""
        total = 0.0
        for fold in range(folds.max() + 1):
            out = folds == fold
            light = self.solve(~out, weight)
            lit = np.maximum(self.basis[out] @ light, _LEVEL)
            rest = ((self.logs[out] - np.log(lit)) ** 2).mean(1)
            bound = (3 * self.settings.noise) ** 2
            total += float(self.weights[out] @ (rest * bound / (rest + bound)))
        return total


def _folds(places: np.ndarray, weights: np.ndarray, halvings: int) -> np.ndarray:
    """(N,) int: parts of a surface, halves of halves by weight across the way in which each is widest.

    A point more or less changes them little, and so whether light is believed in.
    """
    parts = np.zeros(len(places), int)
    for _ in range(halvings):
        halves = np.zeros_like(parts)
        for part in range(parts.max() + 1):
            rows = np.flatnonzero(parts == part)
            if len(rows) < 2:
                halves[rows] = 2 * part
                continue
            axis = int(np.argmax(np.cov(places[rows].T, aweights=weights[rows]).diagonal()))
            order = rows[np.argsort(places[rows, axis], kind="stable")]
            share = np.cumsum(weights[order])
            halves[order] = 2 * part + (share > share[-1] / 2)
        parts = halves
    return parts
