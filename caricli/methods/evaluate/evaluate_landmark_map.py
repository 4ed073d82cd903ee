"""How well a landmark map finds the partners of faces, beside its rivals."""

import numpy as np

from caricli.data.regular_face import has_partners, regular_faces
from caricli.methods.train.see_faces import MapFaces
from caricli.methods.train.stages import Report, unwatched
from caricli.models.landmark_map.model import DOMAINS, LandmarkMap, other
from caricli.structures.landmarks import COUNT


def evaluate_landmark_map(landmark_map: LandmarkMap, faces: MapFaces, report: Report = unwatched) -> dict:
    """Cycle errors of a map, and errors beside its rivals where the true faces are known.

    Returns a JSON object: meshes by part and domain, cycle_error by domain, and error, see ``measure_landmark_map``,
    where the dataset was generated and has caricatures to test with.
    """
    test = {name: seen.points for name, seen in faces.seen["test"].items() if len(seen.points)}
    meshes = {part: {name: len(rows) for name, rows in own.items()} for part, own in faces.rows.items()}
    figures = {"meshes": meshes, "cycle_error": cycle_errors(landmark_map, test)}
    if not has_partners(faces.data) or "caricature" not in test:
        return figures
    pairs = {}
    for done, part in enumerate(("training", "test")):
        report(done, 2)
        shapes = regular_faces(faces.data, faces.rows[part]["caricature"])
        regular = faces.see(shapes, part, "caricature")
        pairs[part] = {"normal": regular.points, "caricature": faces.seen[part]["caricature"].points}
    return figures | {"error": measure_landmark_map(landmark_map, pairs["test"], pairs["training"])}


def landmark_error(points: np.ndarray, true: np.ndarray) -> float:
    """Mean distance of landmarks (N, 68, 2) in percent of the diagonal of the true ones, aligned both."""
    diagonals = np.linalg.norm(np.ptp(true, axis=1), axis=1)
    return float(100 * (np.linalg.norm(points - true, axis=2).mean(1) / diagonals).mean())


def measure_landmark_map(
    landmark_map: LandmarkMap, pairs: dict[str, np.ndarray], training_pairs: dict[str, np.ndarray]
) -> dict[str, dict[str, float]]:
    """Errors of a map and its rivals on pairs of faces.

    pairs, training_pairs: aligned landmarks (N, 68, 2) by domain; the latter train the linear regression between
    principal components, which no other rival needs.
    Returns errors in percent by the domain mapped to and by rival, and "below identity", how much of the error without
    a map is gone, in percent.
    """
    codes = {name: landmark_map.domains[name].encode(training_pairs[name]) for name in DOMAINS}
    figures = {}
    for to in DOMAINS:
        given = pairs[other(to)]
        domain = landmark_map.domains[to]
        regression = np.linalg.lstsq(_with_one(codes[other(to)]), codes[to], rcond=None)[0]
        regressed = domain.decode(_with_one(landmark_map.domains[other(to)].encode(given)) @ regression)
        rivals = {
            "map": landmark_map.map_aligned(given, to),
            "identity": given,
            "mean": np.broadcast_to(domain.mean.reshape(COUNT, 2), given.shape),
            "paired regression": regressed,
        }
        figures[to] = {name: landmark_error(points, pairs[to]) for name, points in rivals.items()}
        figures[to]["below identity"] = 100 * (1 - figures[to]["map"] / figures[to]["identity"])
    return figures


def cycle_errors(landmark_map: LandmarkMap, faces: dict[str, np.ndarray]) -> dict[str, float]:
    """Errors in percent of aligned landmarks (N, 68, 2) by domain, there and back."""
    there = {name: landmark_map.map_aligned(seen, other(name)) for name, seen in faces.items()}
    return {name: landmark_error(landmark_map.map_aligned(there[name], name), seen) for name, seen in faces.items()}


def _with_one(codes: np.ndarray) -> np.ndarray:
    return np.column_stack([codes, np.ones(len(codes))])
