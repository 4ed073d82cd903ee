"""The rival of sketch networks: a linear model fitted to points along the lines (sketch paper, section 6.3)."""

import numpy as np

from caricli.geometry.alignment.fit_camera import fit_camera
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.methods.train.sketch.sketch_hand import LINE, DrawnLines, SketchHand
from caricli.models.linear_model import LinearModel

NOISES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Expected distances of points from their places, of half of the window's side: one is chosen on other people."""

_ROUNDS = 5
"""Of camera and latent in turn, where the camera is not given."""


class SketchFit:
    """Fits a linear model to drawn lines whose curves are known.

    Minimises ``sum_k |s R[:2] p_k(z) + t - q_k|^2 / noise^2 + |z|^2`` over the latent z, whose points p_k stand at the
    same shares of their curves as they do on the mean face; and over the camera, where it is not given.
    """

    def __init__(self, model: LinearModel, hand: SketchHand) -> None:
        """model: LinearModel, its latents in standard deviations. hand: SketchHand of its curves."""
        self.model = model
        parts = [_shares(model.mean[curve.vertices]) for curve in hand.curves]
        ids = [curve.vertices for curve in hand.curves]
        self._mean = np.concatenate([w @ model.mean[i] for w, i in zip(parts, ids, strict=True)])
        basis = [np.einsum("pn,dnk->dpk", w, model.basis[:, i]) for w, i in zip(parts, ids, strict=True)]
        self._basis = np.concatenate(basis, 1)

    def fit(self, drawn: DrawnLines, row: int, noise: float, camera_given: bool) -> np.ndarray:
        """The latent (D,) of a drawn face.

        row: of the drawn lines. noise: see NOISES. camera_given: whether the true camera may be used.
        """
        there = np.repeat(drawn.there[row], LINE)
        points = drawn.lines[row].reshape(-1, 2)[there]
        mean = self._mean[there]
        basis = self._basis[:, there]
        numbers = drawn.cameras[row]
        turn = np.exp(numbers[3]) * head_rotation(numbers[:3])[:2]
        if camera_given:
            return _latent(points - numbers[4:], mean, basis, turn, noise)
        latent = np.zeros(len(basis))
        for _ in range(_ROUNDS):
            camera = fit_camera(mean + np.tensordot(latent, basis, 1), points)
            turn = camera.scale * camera.rotation[:2]
            latent = _latent(points - camera.translation, mean, basis, turn, noise)
        return latent


def _latent(points: np.ndarray, mean: np.ndarray, basis: np.ndarray, turn: np.ndarray, noise: float) -> np.ndarray:
    """Ridge regression for a given camera. turn: (2, 3) scaled rotation."""
    rows = (basis @ turn.T).reshape(len(basis), -1) / noise
    gaps = (points - mean @ turn.T).ravel() / noise
    return np.linalg.solve(rows @ rows.T + np.eye(len(basis)), rows @ gaps)


def _shares(curve: np.ndarray) -> np.ndarray:
    """Weights (LINE, N) of a curve's vertices (N, 3) for points at equal distances along it, seen from the front."""
    reached = arc_lengths(curve[:, :2])
    places = np.interp(np.linspace(0, reached[-1], LINE), reached, np.arange(len(curve)))
    return np.maximum(1 - np.abs(places[:, None] - np.arange(len(curve))), 0)
