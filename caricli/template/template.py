"""The mesh that a shape space deforms, with everything that is known about it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Self

import numpy as np

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.deformation.elastic_anchors import ElasticAnchors
from caricli.geometry.deformation.lengthen_neck import Neck
from caricli.geometry.repair.tuck_cavities import Cavities
from caricli.geometry.repair.untangle import untangle
from caricli.io.kept import kept_arrays
from caricli.structures import Mesh, Part
from caricli.structures.landmarks import POINT_NAMES
from caricli.template.annotation import CAVITIES, EARS, Annotation


@dataclass(frozen=True, eq=False)
class Template(Mesh):
    """A Mesh whose places have names. Its height is what shape errors are measured against.

    annotation: Annotation of the vertices.
    parts: FittedParts of an own topology, None where it has none; those of the open head are told by its topology.
    """

    annotation: Annotation = field(kw_only=True)
    parts: "FittedParts | None" = field(default=None, kw_only=True)

    @cached_property
    def gradients(self) -> DeformationGradients:
        """Deformation gradients against these vertices, factored on first use."""
        return DeformationGradients(self.vertices, self.faces)

    @cached_property
    def anchors(self) -> ElasticAnchors:
        """ElasticAnchors for every vertex that a landmark can stand on, kept for later calls."""
        points = self.annotation.anchor_ids()
        solved = kept_arrays("anchors", (self.vertices, self.faces, points), partial(self._solved_anchors, points))
        return ElasticAnchors(self.vertices, self.faces, points, solved)

    def _solved_anchors(self, points: np.ndarray) -> Mapping[str, np.ndarray]:
        return ElasticAnchors(self.vertices, self.faces, points).solved

    @cached_property
    def cavities(self) -> Cavities:
        """Mouth cavity and eye sockets, as far as the annotation names them, prepared on first use."""
        regions = self.annotation.regions
        return Cavities(self.vertices, self.faces, [regions[name] for name in CAVITIES if name in regions])

    @cached_property
    def neck(self) -> Neck:
        """The neck below the chin, as far as the annotation names it, prepared on first use."""
        note = self.annotation
        still = self.mask(*EARS)
        still[note.landmarks] = True
        neck = note.regions.get("neck", np.zeros(0, np.int64))
        return Neck(self.vertices, self.faces, neck, int(note.landmarks[POINT_NAMES["chin"]]), still)

    def mended(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) of this mesh with flipped triangles turned back and cavities behind the skin."""
        return self.cavities.tuck(untangle(vertices, self.gradients))

    def region(self, name: str) -> np.ndarray:
        """Vertex ids of a region; all vertices where the annotation does not name it."""
        return self.annotation.regions.get(name, np.arange(len(self.vertices)))

    def mask(self, *names: str) -> np.ndarray:
        """(V,) bool: vertices in any of the regions that the annotation names."""
        mask = np.zeros(len(self.vertices), dtype=bool)
        for name in names:
            mask[self.annotation.regions.get(name, [])] = True
        return mask


@dataclass(frozen=True, eq=False)
class WholeHead(Template):
    """A Template in the shape of a face, with what is on and in this face.

    dressed: Parts of the face; the same template in another shape has none until they are attached to it.
    eyes: whether it is drawn with eyeballs.
    """

    dressed: tuple[Part, ...] = field(default=(), kw_only=True)
    eyes: bool = field(default=True, kw_only=True)

    def with_vertices(self, vertices: np.ndarray) -> Self:
        """The same template in another shape, without parts. vertices: (V, 3), as many as there are."""
        other = super().with_vertices(vertices)
        object.__setattr__(other, "dressed", ())
        return other


@dataclass(frozen=True, eq=False)
class FittedParts:
    """Parts of an own topology and the head that they were modelled in, whatever shape a template has.

    head: Template in that shape. parts: without expressions of their own.
    """

    head: Template
    parts: tuple[Part, ...]
