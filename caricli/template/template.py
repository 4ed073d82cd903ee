"""The mesh that a shape space deforms, with everything that is known about it."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.geometry.deformation_gradients import DeformationGradients
from caricli.geometry.tuck_cavities import Cavities
from caricli.io.face import topology_id
from caricli.template.annotation import Annotation

CAVITIES = ("inner_mouth", "eye_socket_left", "eye_socket_right")


@dataclass(frozen=True)
class Template:
    """vertices (V, 3) metres; faces (F, 3); polygons (P, N) padded with -1; uvs (T, 2); uv_polygons (P, N)."""

    vertices: np.ndarray
    faces: np.ndarray
    polygons: np.ndarray
    annotation: Annotation
    uvs: np.ndarray | None = None
    uv_polygons: np.ndarray | None = None

    @property
    def height(self):
        """Vertical extent in metres: what shape errors are measured against."""
        return float(np.ptp(self.vertices[:, 1]))

    @cached_property
    def topology_id(self):
        """SHA-256 of the faces."""
        return topology_id(self.faces)

    @cached_property
    def gradients(self):
        """Deformation gradients against these vertices, factored on first use."""
        return DeformationGradients(self.vertices, self.faces)

    @cached_property
    def cavities(self):
        """Mouth cavity and eye sockets, as far as the annotation names them, prepared on first use."""
        regions = self.annotation.regions
        return Cavities(self.vertices, self.faces, [regions[name] for name in CAVITIES if name in regions])

    def region(self, name):
        """Vertex ids of a region; all vertices where the annotation does not name it."""
        return self.annotation.regions.get(name, np.arange(len(self.vertices)))

    def mask(self, *names):
        """(V,) bool: vertices in any of the regions that the annotation names."""
        mask = np.zeros(len(self.vertices), dtype=bool)
        for name in names:
            mask[self.annotation.regions.get(name, [])] = True
        return mask

    def with_vertices(self, vertices):
        """The same mesh in another shape."""
        return replace(self, vertices=vertices)
