"""What a gesture did."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.structures import Face


@dataclass(frozen=True, eq=False)
class Changed:
    """A face after a gesture.

    face: Face with all else that it had; what a latent cannot express is found by ``encode_face``. share: of what was
    asked for, as far as no triangle turned over. moved: metres, the longest way of a vertex. region: (R,) ids that
    could move.
    """

    face: Face
    share: float
    moved: float
    region: np.ndarray

    @classmethod
    def of(cls, before: Face, vertices: np.ndarray, share: float, region: np.ndarray) -> "Changed":
        """vertices: (V, 3) after the gesture. region: (V,) bool."""
        moved = float(np.linalg.norm(vertices - before.vertices, axis=1).max())
        return cls(replace(before.with_vertices(vertices), residual=None), share, moved, np.flatnonzero(region))
