"""Points in a head as weighted means of vertices of its skin."""

from dataclasses import astuple, dataclass

import numpy as np

from caricli.io.kept import kept_arrays


@dataclass(frozen=True)
class FollowSettings:
    """How points follow a skin.

    stiffness: share of the head's height; the weight against large weights, which would carry every roughness of a
    skin into the head. fields: number of smooth moves of space that points take part in, whatever else is known of
    them; reach, size: their reach and their length, shares of the height. exact: weight of what must hold.
    """

    stiffness: float = 0.001
    fields: int = 200
    reach: float = 0.12
    size: float = 0.003
    exact: float = 1e3


def follow_weights(
    anchors: np.ndarray, points: np.ndarray, examples: tuple[np.ndarray, np.ndarray], height: float
) -> np.ndarray:
    """Weights W with ``points = W anchors`` in the template, under every affine map, and as well as can be in examples.

    Minimises ``|D_points - W D_anchors|^2 + stiffness^2 |W|^2`` over the examples and over smooth fields, subject to
    rows of W that sum to one and give the points of the template.

    anchors: (J, 3), points: (Q, 3) of the template, metres. examples: displacements (n, J, 3) of the anchors and
    (n, Q, 3) of the points. height: metres, of the head.
    Returns (Q, J).
    """
    settings = FollowSettings()
    given = (anchors, points, *examples, height, *astuple(settings))
    return kept_arrays("follow", given, lambda: {"weights": _solve(anchors, points, examples, height, settings)})[
        "weights"
    ]


def _solve(
    anchors: np.ndarray,
    points: np.ndarray,
    examples: tuple[np.ndarray, np.ndarray],
    height: float,
    settings: FollowSettings,
) -> np.ndarray:
    moved, answers = (np.moveaxis(example, 1, 2).reshape(-1, example.shape[1]) for example in examples)
    fields = [_fields(places, anchors, height, settings) for places in (anchors, points)]
    # The examples of all axes share one row of weights, so that a turned head is treated as one that is not.
    moved = np.concatenate([moved, fields[0], settings.stiffness * height * np.eye(len(anchors))]) / height
    answers = np.concatenate([answers, fields[1], np.zeros((len(anchors), len(points)))]) / height
    fixed = np.concatenate([anchors, np.full((len(anchors), 1), height)], axis=1).T / height
    aims = np.concatenate([points, np.full((len(points), 1), height)], axis=1).T / height
    system = np.block([[moved.T @ moved, fixed.T], [fixed, np.zeros((4, 4))]])
    return np.linalg.solve(system, np.concatenate([moved.T @ answers, aims]))[: len(anchors)].T


def _fields(places: np.ndarray, anchors: np.ndarray, height: float, settings: FollowSettings) -> np.ndarray:
    """(fields, N) lengths of smooth moves around the anchors' box at places (N, 3)."""
    low = anchors.min(0) - settings.reach * height
    span = np.ptp(anchors, axis=0) + 2 * settings.reach * height
    # Points of a generalised golden section fill the box evenly.
    ratios = 1 / 1.2207440846 ** np.arange(1, 4)
    centres = low + span * ((0.5 + np.arange(settings.fields)[:, None] * ratios) % 1.0)
    squared = ((places[None] - centres[:, None]) ** 2).sum(-1)
    return settings.size * height * np.exp(-0.5 * squared / (settings.reach * height) ** 2)
