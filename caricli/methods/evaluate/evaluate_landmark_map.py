"""How well a landmark map finds the partners of faces, beside its rivals."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from caricli.data.regular_face import has_partners, regular_faces
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.train.see_faces import MapFaces
from caricli.methods.train.stages import Report, unwatched
from caricli.models.landmark_map.model import LandmarkMap
from caricli.structures.landmarks import COUNT

NEAREST = 10
"""Draws of which the nearest counts: of one normal face there are many caricatures."""

_DRAWS = 1000
"""Of a bootstrap over people."""

_SEED = 21
"""Of all draws here."""


@dataclass(frozen=True, eq=False)
class FacePairs:
    """Faces as caricatures and as they were before.

    normal, caricature: aligned landmarks (N, 68, 2), the same person, expression and pose in a row. people: (N,) whose.
    """

    normal: np.ndarray
    caricature: np.ndarray
    people: np.ndarray


def evaluate_landmark_map(landmark_map: LandmarkMap, faces: MapFaces, report: Report = unwatched) -> dict:
    """How near a map comes to the true faces, beside its rivals, on people held out of the training and the test split.

    Returns a JSON object: meshes by part and domain, and error, see ``measure_landmark_map``, by part where the dataset
    was generated and the part has caricatures.
    """
    meshes = {part: {name: len(rows) for name, rows in own.items()} for part, own in faces.rows.items()}
    if not has_partners(faces.data):
        return {"meshes": meshes}
    pairs = {}
    for done, (part, own) in enumerate(meshes.items()):
        report(done, len(meshes))
        if own["caricature"]:
            pairs[part] = face_pairs(faces, part)
    training = pairs.pop("training")
    return {"meshes": meshes, "error": {k: measure_landmark_map(landmark_map, v, training) for k, v in pairs.items()}}


def face_pairs(faces: MapFaces, part: str) -> FacePairs:
    """The caricatures of a part and the regular faces that they were made of, in the same poses."""
    regular = regular_faces(faces.data, faces.rows[part]["caricature"])
    people = faces.people(part, "caricature")
    return FacePairs(faces.see(regular, part, "caricature"), faces.seen[part]["caricature"], people)


def measure_landmark_map(landmark_map: LandmarkMap, pairs: FacePairs, training: FacePairs) -> dict[str, dict]:
    """Errors of a map and its rivals on pairs of faces.

    Where a rival has draws, the nearest of NEAREST counts. training: pairs that linear regression learns from, and what
    random caricatures are of; the map needs none.
    Returns by the domain mapped to and by rival what ``error_figures`` says; and, in percent of the faces' diagonal,
    "spread", how far two draws of one face are from each other, beside what true caricatures add to two faces.
    """
    given = pairs.normal
    back = regression(training.caricature, training.normal)
    forth = regression(training.normal, training.caricature)
    likeliest = landmark_map.map_aligned(given, "caricature")
    added = training.caricature - forth(training.normal)
    mean = landmark_map.caricature.reshape(COUNT, 2)
    normal = {
        "map": landmark_map.map_aligned(pairs.caricature, "normal"),
        "identity": pairs.caricature,
        "mean": np.broadcast_to(landmark_map.normal.reshape(COUNT, 2), given.shape),
        "paired regression": back(pairs.caricature),
    }
    caricature = {
        "map": draws(likeliest, landmark_map.styles),
        "its likeliest caricature": likeliest,
        "its own style": np.array(
            [landmark_map.map_aligned(f, "caricature", landmark_map.own_style(f)) for f in given]
        ),
        "identity": given,
        "identity with draws": draws(given, components(training.caricature, len(landmark_map.styles))),
        "mean": np.broadcast_to(mean, given.shape),
        "random caricatures": _generator().choice(training.caricature, (NEAREST, len(given))),
        "paired regression": forth(given),
        "paired regression with draws": draws(forth(given), components(added, len(landmark_map.styles))),
    }
    figures = {
        "normal": compare(normal, pairs.normal, pairs.people),
        "caricature": compare(caricature, pairs.caricature, pairs.people),
    }
    return figures | {"spread": {"map": spread(caricature["map"], likeliest), "truth": true_spread(pairs)}}


def compare(rivals: Mapping[str, np.ndarray], true: np.ndarray, people: np.ndarray) -> dict[str, dict[str, float]]:
    """``error_figures`` by rival. rivals: landmarks (N, 68, 2), or draws (K, N, 68, 2) of which the nearest counts."""
    errors = {name: face_errors(points, true) for name, points in rivals.items()}
    errors = {name: own.min(0) if own.ndim == 2 else own for name, own in errors.items()}
    return {name: error_figures(own, errors["identity"], people) for name, own in errors.items()}


def face_errors(points: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Mean distance (..., N) of aligned landmarks (..., N, 68, 2) in percent of the diagonal of the true ones."""
    diagonals = np.linalg.norm(np.ptp(true, axis=-2), axis=-1)
    return 100 * np.linalg.norm(points - true, axis=-1).mean(-1) / diagonals


def error_figures(errors: np.ndarray, identity: np.ndarray, people: np.ndarray) -> dict[str, float]:
    """A JSON object: error, the mean; and below_identity, how much of the error without a map is gone, in percent, with
    low and high of its ``ratio_interval``.

    errors, identity: (N,) of a rival and without a map. people: (N,) whose.
    """
    below, low, high = ratio_interval(100 * (identity - errors), identity, people, _DRAWS, _SEED)
    return {"error": float(errors.mean()), "below_identity": below, "low": low, "high": high}


def draws(points: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Landmarks (N, 68, 2) with normally distributed parts (D, 136) added, NEAREST times, (K, N, 68, 2)."""
    codes = _generator().standard_normal((NEAREST, len(points), len(parts)))
    return points + (codes @ parts).reshape(NEAREST, *points.shape)


def components(points: np.ndarray, count: int) -> np.ndarray:
    """The largest principal components (D, 136) of landmarks (N, 68, 2), one standard deviation each."""
    values, vectors = np.linalg.eigh(np.cov(points.reshape(len(points), -1).T))
    return (vectors * np.sqrt(np.maximum(values, 0))).T[::-1][:count]


def regression(given: np.ndarray, wanted: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Linear regression between pairs of landmarks (N, 68, 2), with a ridge."""
    start, end = (points.reshape(len(points), -1) for points in (given, wanted))
    centre, aim = (rows.mean(0) for rows in (start, end))
    rows = start - centre
    ridge = _RIDGE * np.square(rows).sum() * np.eye(rows.shape[1])
    weights = np.linalg.solve(rows.T @ rows + ridge, rows.T @ (end - aim))
    return lambda points: ((points.reshape(len(points), -1) - centre) @ weights + aim).reshape(points.shape)


_RIDGE = 1e-4
"""Of a regression, of the squares that are regressed on."""


def spread(drawn: np.ndarray, around: np.ndarray) -> float:
    """Mean distance between two draws (K, N, 68, 2) of a face (N, 68, 2), in percent of its diagonal."""
    return float(face_errors(drawn[1:] - drawn[:-1] + around, around).mean())


def true_spread(pairs: FacePairs) -> float:
    """How far what caricatures add to a face is from what they add to another, as ``spread``."""
    added = pairs.caricature - pairs.normal
    others = added[_generator().permutation(len(added))]
    return float(face_errors(added - others + pairs.normal, pairs.normal).mean())


def _generator() -> np.random.Generator:
    return np.random.default_rng(_SEED)
