"""The curves of a head that a sketch of it shows."""

from dataclasses import dataclass, field

import numpy as np

from caricli.errors import InputError
from caricli.structures.landmarks import COUNT
from caricli.structures.sketch import CURVES, StrokeKind
from caricli.template.annotation import Annotation, bundled_annotation

SILHOUETTE = "silhouette"
"""Name of the curve around the face as the front shows it."""


@dataclass(frozen=True, eq=False)
class FeatureCurve:
    """A line on a head.

    name: of the annotation. kind: StrokeKind of its stroke. vertices: (N,) ids along edges of the mesh; of a closed
    curve the last is the first. marks: (M,) numbers along the curve of those that iBUG's landmarks stand on, in their
    order along it; of the silhouette from ear to ear.
    """

    name: str
    kind: StrokeKind
    vertices: np.ndarray
    marks: np.ndarray = field(default_factory=lambda: np.zeros(0, int))

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
        return bool(self.vertices[0] == self.vertices[-1])


def named_curves(annotation: Annotation) -> tuple[FeatureCurve, ...]:
    """``feature_curves`` of an annotation that names some. Raises InputError for another."""
    curves = feature_curves(annotation)
    if not curves:
        raise InputError("expected a model whose annotation names the curves that a sketch shows, found none")
    return curves


def feature_curves(annotation: Annotation) -> tuple[FeatureCurve, ...]:
    """What a sketch shows of a head, the silhouette first: the curves that its annotation names.

    annotation: of a template. An older annotation of the bundled head, which lacks some, is completed.
    Returns FeatureCurves of at least two vertices each.
    """
    bundled = bundled_annotation()
    note = bundled if _same_head(annotation, bundled) else annotation
    closed = note.source.get("closed_curves", [])
    curves = []
    for name, ids in sorted(note.curves.items(), key=lambda item: item[0] != SILHOUETTE):
        if len(ids) > 1:
            vertices = np.append(ids, ids[0]) if name in closed and ids[0] != ids[-1] else ids
            around = vertices[0] == vertices[-1]
            marks = np.flatnonzero(np.isin(vertices[: len(vertices) - around], note.landmarks[:COUNT]))
            if around:
                marks = _around(marks, len(vertices) - 1)
            curves.append(FeatureCurve(name, CURVES.get(name, StrokeKind.FEATURE), vertices, marks))
    return tuple(curves)


def _around(marks: np.ndarray, count: int) -> np.ndarray:
    """Marks (M,) of a ring of count vertices, the first behind the widest gap."""
    if len(marks) < 2:
        return marks
    return np.roll(marks, -1 - int(np.diff(marks, append=marks[0] + count).argmax()))


def _same_head(annotation: Annotation, other: Annotation) -> bool:
    mirror = annotation.mirror
    if mirror is None or other.mirror is None or not np.array_equal(mirror, other.mirror):
        return False
    return all(np.array_equal(ids, other.curves.get(name, ())) for name, ids in annotation.curves.items())
