"""The light on a face, from the colours of its skin: nine spherical harmonics of the normals."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.geometry.weighted_medians import weighted_medians
from caricli.render.sky import sphere_directions
from caricli.render.smooth_normals import even_normals

GAMMA = 2.2
"""Exponent from sRGB to linear light, near enough for ratios."""

_LEVEL = 1e-6
_DOME = 400


@dataclass(frozen=True)
class LightSettings:
    """How light is told from colours.

    spread: of the coefficients of the first and the second order, standard deviations for that of the constant one.
    noise: standard deviation of the skin's own colour, of logarithms. outlier: in units of the residuals' spread, from
    where on a colour counts as another thing than skin. weights: of the spread against the mean square of the
    logarithms, of which that is taken that foretells left-out parts best. halvings: into these parts. gain: share of
    the left-out error that light has to explain before it is believed in. rounds: of reweighting. range: least and
    greatest light, of the mean one. least: points of skin, with fewer nothing is told. brightest: mean light on the
    skin that is seen, at most: none of 150 generated heads in random light has more, but drawings whose outlines are
    dark look as if lit from before them.
    """

    spread: tuple[float, float] = (0.5, 0.25)
    noise: float = 0.1
    outlier: float = 2.5
    weights: tuple[float, ...] = (1e-4, 1e-3, 1e-2)
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
    Returns Light, or None where it explains too little.
    """
    settings = LightSettings()
    used = weights > 0
    if used.sum() < settings.least:
        return None
    logs = GAMMA * np.log(np.clip(colours[used], 1, 255) / 255)
    fit = _Fit(harmonics(normals[used]), logs, weights[used] / weights[used].sum(), settings)
    folds = _folds(places[used], weights[used], settings.halvings)
    constant = fit.missed(folds, np.inf)
    missed = [fit.missed(folds, weight) for weight in settings.weights]
    best = int(np.argmin(missed))
    explained = 1 - missed[best] / max(constant, _LEVEL)
    if explained < settings.gain:
        return None
    light = fit.solve(np.ones(len(logs)), settings.weights[best])
    dome = sphere_directions(_DOME)
    # An incident light meter beside the face would say one.
    light = light / np.maximum(harmonics(dome[dome @ view > 0]) @ light, _LEVEL).mean(0)
    lit = harmonics(normals[used]) @ light
    dimmed = min(settings.brightest / max(float(np.average(lit, 0, weights[used]).mean()), _LEVEL), 1.0)
    light, lit = light * dimmed, lit * dimmed
    return Light(light, np.clip(np.quantile(lit, [0.01, 0.99], axis=0), *settings.range), float(explained))


class _Fit:
    """Skin in light: harmonics (N, 9), logarithms (N, 3) of colours, weights (N,)."""

    def __init__(self, basis: np.ndarray, logs: np.ndarray, weights: np.ndarray, settings: LightSettings) -> None:
        self.basis = basis
        self.logs = logs
        self.weights = weights
        self.settings = settings
        self.stiff = np.repeat([0.0, *(1 / spread**2 for spread in settings.spread)], [1, 3, 5])

    def solve(self, kept: np.ndarray, weight: float) -> np.ndarray:
        """(9, 3) coefficients by points that are kept, (N,) 0 or 1; of a weight of their spread, inf for no light."""
        weights = self.weights * kept
        middle = np.exp(weighted_medians(self.logs, weights))
        light = np.zeros((9, 3))
        light[0] = middle / self.basis[0, 0]
        for _ in range(self.settings.rounds):
            lit = np.maximum(self.basis @ light, 0.1 * middle)
            rest = self.logs - np.log(lit)
            robust = weights * self.trust(rest, weights)
            size = 1 if np.isinf(weight) else 9
            basis = self.basis[:, :size]
            stiff = np.zeros((3, size)) if size == 1 else weight * robust.sum() * self.stiff / light[0, :, None] ** 2
            scaled = (robust[:, None] / lit**2).T[:, :, None] * basis
            left = scaled.transpose(0, 2, 1) @ basis + np.einsum("ci,ij->cij", stiff + _LEVEL**2, np.eye(size))
            right = (robust[:, None] * rest / lit).T @ basis - stiff * light[:size].T
            light[:size] += np.linalg.solve(left, right[..., None])[..., 0].T
        return light

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
