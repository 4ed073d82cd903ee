"""The landmarks that a landmark map is trained and measured on: faces of a dataset in random poses."""

from dataclasses import dataclass, field, replace

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.unseen import seen_people
from caricli.geometry.alignment.head_rotation import TURNS, head_rotation
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.train.stages import Report, unwatched
from caricli.models.landmark_map.model import DOMAINS, align
from caricli.structures import SeenPeople
from caricli.structures.landmarks import COUNT
from caricli.template.template import Template

PARTS = ("training", "held out", "test")
"""What faces are for: to learn from, to choose settings by, and to measure with."""

HELD_OUT = 10
"""Of the people trained on every tenth is held out, to choose settings by."""


@dataclass(frozen=True, eq=False)
class MapFaces:
    """All faces of a dataset that a landmark map has to do with.

    data: Dataset. rows: (n,) numbers of meshes by PARTS and DOMAINS. views: poses a mesh. seed: of the poses.
    seen: aligned landmarks (n * views, 68, 2) by PARTS and DOMAINS, all poses of a mesh after each other.
    """

    data: Dataset
    rows: dict[str, dict[str, np.ndarray]]
    views: int
    seed: int
    seen: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)

    def poses(self, part: str, domain: str) -> np.random.Generator:
        """What the poses of a part and a domain are drawn from: they depend on nothing else but the seed."""
        return np.random.default_rng([self.seed, PARTS.index(part), DOMAINS.index(domain)])

    def see(self, vertices: np.ndarray, part: str, domain: str) -> np.ndarray:
        """Landmarks as in ``seen`` of shapes (n, V, 3) that stand in for the meshes of a part and a domain."""
        return see_faces(vertices, self.data.template, self.views, self.poses(part, domain))

    def people(self, part: str, domain: str) -> np.ndarray:
        """Whose face each of ``seen`` is, (n * views,)."""
        return np.repeat(self.data.identity[self.rows[part][domain]], self.views)

    def seen_people(self) -> SeenPeople:
        """Whom a training sees: those that it learns from, and those held out to choose settings by."""
        uses = {"train": PARTS[0], "validation": PARTS[1]}
        splits = {use: np.unique(self.data.identity[_all(self.rows[part])]).tolist() for use, part in uses.items()}
        return seen_people(replace(self.data, manifest=self.data.manifest | {"splits": splits}))


def map_faces(data: Dataset, views: int, seed: int, report: Report = unwatched) -> MapFaces:
    """See the faces of a dataset: those trained on, those held out of them, and those of the test split.

    views: poses a mesh.
    """
    faces = MapFaces(data, _rows(data), views, seed)
    parts = [(part, domain) for part in PARTS for domain in DOMAINS]
    for done, (part, domain) in enumerate(parts):
        report(done, len(parts))
        shapes = data.vertices[faces.rows[part][domain]].astype(np.float64)
        faces.seen.setdefault(part, {})[domain] = faces.see(shapes, part, domain)
    return faces


def see_faces(vertices: np.ndarray, template: Template, views: int, generator: np.random.Generator) -> np.ndarray:
    """Landmarks of meshes in random poses, those of the jaw on the outline.

    vertices: (N, V, 3). views: poses a mesh.
    Returns (N * views, 68, 2), aligned.
    """
    turns = generator.uniform(-1, 1, (len(vertices), views, 3))
    points = np.empty((len(vertices), views, COUNT, 2))
    for k, shape in enumerate(vertices):
        for view, turn in enumerate(turns[k]):
            rotation = head_rotation(turn * TURNS)
            points[k, view] = shape[landmark_vertices(shape, rotation, template, COUNT)] @ rotation[:2].T
    return align(points.reshape(-1, COUNT, 2))[0]


def _all(rows: dict[str, np.ndarray]) -> np.ndarray:
    """Numbers of meshes of all domains."""
    return np.concatenate([*rows.values()])


def _rows(data: Dataset) -> dict[str, dict[str, np.ndarray]]:
    """Numbers of meshes by PARTS and DOMAINS."""
    people = np.array(data.manifest["splits"]["train"])
    held = np.isin(data.identity, people[HELD_OUT - 1 :: HELD_OUT]) | data.rows("validation")
    masks = {"training": data.rows("train") & ~held, "held out": held, "test": data.rows("test")}
    domains = {"normal": data.regular, "caricature": ~data.regular}
    return {part: {name: np.flatnonzero(mask & own) for name, own in domains.items()} for part, mask in masks.items()}
