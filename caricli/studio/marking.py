"""Landmarks of a picture as the page shows them: points, the other side of the face, and the face that follows them."""

from typing import Any, cast

import numpy as np

from caricli.errors import CaricliError
from caricli.methods.marks.mirror_map import mirror_map
from caricli.methods.reconstruct.fit_landmarks_intrinsic import LandmarkChase
from caricli.methods.sketch.draw_sketch import draw_curves
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.shape_model import ShapeModel
from caricli.structures import Landmarks
from caricli.structures.landmarks import GROUPS, MIRRORED, POLYLINES, RINGS, point_label
from caricli.template.feature_curves import feature_curves


class Marking:
    """What the canvas of landmarks is told. It runs in one thread, and keeps the face of the last look."""

    def __init__(self, model: ShapeModel) -> None:
        """model: IntrinsicModel whose face follows the landmarks."""
        assert model.kind == "intrinsic"
        self.model = cast(IntrinsicModel, model)
        self.curves = feature_curves(model.template.annotation)
        self.chase = LandmarkChase(self.model)

    def scene(self, count: int, size: tuple[int, int], address: str) -> dict[str, Any]:
        """A picture to begin with, as JSON. count: of points. size: (width, height). address: of the picture."""
        self.chase = LandmarkChase(self.model)
        lines = [list(line) for line in POLYLINES] + [[*ring, ring[0]] for ring in RINGS]
        return {
            "src": address,
            "size": list(size),
            "labels": [point_label(number) for number in range(count)],
            "groups": {name: [k for k in numbers if k < count] for name, numbers in GROUPS.items()},
            "mirrored": list(MIRRORED[:count]),
            "lines": lines,
        }

    def state(self, landmarks: Landmarks, seq: int | None = None) -> dict[str, Any]:
        """Landmarks and the face that follows them, as JSON. seq: of the try that this answers."""
        points = landmarks.points
        state: dict[str, Any] = {
            "points": [None if np.isnan(point).any() else point.tolist() for point in points],
            "guess": [],
            "curves": [],
        }
        # A move in the other half is told by the points before it.
        state |= {"mirror": self._mirror(points)} if seq is None else {"seq": seq}
        try:
            face = self.chase.look(landmarks.head_points, landmarks.spreads)
        except CaricliError:
            # Points that no face has, or too few of them, are still points.
            self.chase = LandmarkChase(self.model)
            return state
        strokes = draw_curves(face.vertices, self.curves, face.require_camera())
        state["guess"] = np.round(face.require_landmarks(), 3).tolist()
        state["curves"] = [np.round(stroke.points, 1).tolist() for stroke in strokes]
        return state

    def _mirror(self, points: np.ndarray) -> list | None:
        """What a move is on the other side, or None where the points tell no pose."""
        try:
            return mirror_map(points, self.model.template).tolist()
        except CaricliError:
            return None
