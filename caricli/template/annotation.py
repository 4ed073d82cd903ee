"""What is known by name on a head: landmarks, jaw paths, curves, regions, mirror map, eyeballs."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError


@dataclass(frozen=True)
class Annotation:
    """Vertex ids by name; ``source`` is the JSON value it was read from, kept so that a checkpoint can carry it."""

    landmarks: np.ndarray
    jaw_paths: tuple
    curves: dict
    regions: dict
    mirror: np.ndarray | None
    eyeballs: dict
    source: dict

    @property
    def has_extra(self):
        """Whether the 13 points beyond iBUG-68 are there."""
        return len(self.landmarks) == 81

    def anchor_ids(self):
        """Every vertex that a landmark can stand on, the jaw paths included, without repeats."""
        return np.unique(np.concatenate([self.landmarks, *self.jaw_paths]))


def parse_annotation(value, vertex_count, where):
    """Check an annotation's JSON value against a mesh.

    value: dict of the form of ``assets/head_annotation.json``; only ``ibug68`` is required. ``extra13``, ``jaw_paths``
    (17 lists of vertex ids, back to front), ``curves``, ``regions``, ``mirror`` and ``eyeballs`` may be absent.
    vertex_count: V. where: the file's name, for messages.
    Returns Annotation. Raises InputError.
    """
    if not isinstance(value, dict):
        found = type(value).__name__
        raise InputError(f"{where}: expected a JSON object with vertex ids under 'ibug68', found {found}")

    def ids(key, item, count=None):
        array = np.asarray(item if isinstance(item, list) else None, dtype=object)
        if array.ndim != 1 or not all(type(i) is int and 0 <= i < vertex_count for i in array):
            raise InputError(f"{where}: '{key}' must be a list of vertex ids from 0 to {vertex_count - 1}")
        if count is not None and len(array) != count:
            raise InputError(f"{where}: '{key}' must have {count} vertex ids, found {len(array)}")
        return array.astype(np.int64)

    def table(key):
        entries = value.get(key, {})
        if not isinstance(entries, dict):
            raise InputError(f"{where}: '{key}' must map names to lists of vertex ids")
        return {name: ids(f"{key}.{name}", item) for name, item in entries.items()}

    if "ibug68" not in value:
        raise InputError(f"{where}: 'ibug68', the 68 landmark vertices, is missing")
    landmarks = ids("ibug68", value["ibug68"], 68)
    if "extra13" in value:
        landmarks = np.concatenate([landmarks, ids("extra13", value["extra13"], 13)])
    paths = value.get("jaw_paths", [[int(i)] for i in landmarks[:17]])
    if not isinstance(paths, list) or len(paths) != 17:
        raise InputError(f"{where}: 'jaw_paths' must be 17 lists of vertex ids")
    jaw_paths = tuple(ids(f"jaw_paths[{k}]", path) for k, path in enumerate(paths))
    if any(landmark not in path for landmark, path in zip(landmarks[:17], jaw_paths, strict=True)):
        raise InputError(f"{where}: every path in 'jaw_paths' must contain the jaw landmark that slides along it")
    mirror = ids("mirror", value["mirror"], vertex_count) if "mirror" in value else None
    if mirror is not None and not np.array_equal(mirror[mirror], np.arange(vertex_count)):
        raise InputError(f"{where}: 'mirror' must be its own inverse")
    eyeballs = value.get("eyeballs", {})
    if not isinstance(eyeballs, dict):
        raise InputError(f"{where}: 'eyeballs' must be an object")
    return Annotation(landmarks, jaw_paths, table("curves"), table("regions"), mirror, eyeballs, value)
