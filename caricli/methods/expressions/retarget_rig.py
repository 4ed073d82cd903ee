"""A caricature that does what normal faces do."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.animate.pose_rig import RigPoser
from caricli.methods.dynamic.rig_moods import MoodPainter
from caricli.methods.expressions.retarget_expression import (
    Explanation,
    RetargetSettings,
    explain_landmarks,
    explain_meshes,
)
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.models.morphable.model import MorphableModel
from caricli.structures import Animation, Face, Landmarks, Rig
from caricli.structures.arkit import arkit_name, opposites, uses, within_reach
from caricli.structures.texture_change import TextureChange
from caricli.template.template import Template

_SAID = 3
"""Expressions that a line names."""

_SEEN = 0.05
"""Weight from which on an expression is seen."""


@dataclass(frozen=True, eq=False)
class DrivingMesh:
    """A normal face. vertices: (N, 3), of the model's topology, anywhere and in any size."""

    vertices: np.ndarray


@dataclass(frozen=True, eq=False)
class DrivingLandmarks:
    """The landmarks of a normal face. points: (L, 2) pixels, NaN where unknown. fit: LandmarkFit of them."""

    points: np.ndarray
    fit: LandmarkFit


Driver = DrivingMesh | DrivingLandmarks


def fit_driver(landmarks: Landmarks, model: MorphableModel) -> DrivingLandmarks:
    """Find the camera that landmarks were seen with. Raises InputError, NumericsError."""
    return DrivingLandmarks(
        landmarks.head_points, fit_morphable(landmarks.head_points, model, spreads=landmarks.spreads)
    )


@dataclass(frozen=True, eq=False)
class Retargeting:
    """What T normal faces do, done by a rig.

    rig: Rig that knows what its expressions do to a normal face.
    template: Template of the normal face.
    explanation: weights and the neutral face of all drivers.
    unit: of what is left: "mm" from meshes, "percent" of the diagonal from landmarks.
    painter: MoodPainter of the rig's skin, or None to leave its picture.
    """

    rig: Rig
    template: Template
    explanation: Explanation
    unit: str
    painter: MoodPainter | None = None

    def vertices(self, t: int) -> np.ndarray:
        """(V, 3) float64 of the rig with the expression of driver t."""
        return RigPoser(self.rig).pose(self.explanation.weights[t]).astype(float)

    def change(self, t: int) -> TextureChange | None:
        """What the expression of driver t does to the picture of the skin, or None to leave it."""
        return None if self.painter is None else self.painter.change(self.explanation.weights[t])

    def caricature(self, t: int) -> Face:
        """The Face of the rig with the expression of driver t, in what the rig wears, its skin painted."""
        face = self.rig.face.posed(self.vertices(t))
        if self.painter is None:
            return face
        skin = self.painter.paint(self.explanation.weights[t])
        return replace(face, pictures=replace(face.pictures, skin=skin))

    def driver(self, t: int) -> Template:
        """The normal face as it is explained."""
        moved = np.tensordot(self.explanation.weights[t], self.rig.require_normal_deltas(), 1)
        return self.template.with_vertices(self.explanation.neutral + moved)

    def animation(self, fps: float) -> Animation:
        """The rig moving through all drivers, so many a second."""
        weights = self.explanation.weights
        return Animation(np.arange(len(weights)) / fps, weights)

    def weights_by_name(self) -> dict[str, list[float]]:
        """Of every expression the weights (T,)."""
        return dict(zip(self.rig.names, self.explanation.weights.T.tolist(), strict=True))

    def figures(self, t: int) -> dict:
        """Weights by name and what is left, as JSON holds them."""
        weights = dict(zip(self.rig.names, self.explanation.weights[t].tolist(), strict=True))
        return {"weights": weights, f"left_{self.unit}": float(self.explanation.errors[t])}

    def describe(self, t: int) -> str:
        """The strongest expressions, and what is left."""
        weights = self.explanation.weights[t]
        strong = [k for k in np.argsort(-weights, kind="stable") if weights[k] >= _SEEN]
        named = ", ".join(f"{self.rig.names[k]} {weights[k]:.2f}" for k in strong[:_SAID]) or "no expression"
        more = f" and {len(strong) - _SAID} more" if len(strong) > _SAID else ""
        return f"{named}{more}; {self.explanation.errors[t]:.2f} {self.unit} unexplained"


def retarget_rig(
    drivers: Sequence[Driver], rig: Rig, model: MorphableModel, neutral: np.ndarray | None = None
) -> Retargeting:
    """Explain what normal faces of one person do by the expressions of a rig.

    One that only means something on top of another comes with it: lips close on an open jaw, and not more than it is.
    Nor does a squint close more of an eye than a blink leaves open. Without a neutral face that is given, none does two
    ``OPPOSITES`` at once.

    drivers: all meshes or all landmarks. neutral: (N, 3) metres, the neutral face of the person in driving meshes, or
    None.
    Raises InputError where no expression moves a normal face.
    """
    meshes = [driver.vertices for driver in drivers if isinstance(driver, DrivingMesh)]
    seen = [driver for driver in drivers if isinstance(driver, DrivingLandmarks)]
    together = uses(rig.names)
    deltas = np.tensordot(together, rig.require_normal_deltas(), 1)
    # A neutral face that is given leaves no doubt that a face does both.
    settings = RetargetSettings(opposites=opposites(rig.names) if neutral is None else ())
    if meshes:
        explanation = explain_meshes(meshes, deltas, model, neutral, settings)
    else:
        # No landmark shows a tongue or an iris, and what they do to lips and lids others do as well.
        deltas[[(arkit_name(name) or "").startswith(("tongueOut", "eyeLook")) for name in rig.names]] = 0
        points = [driver.points for driver in seen]
        explanation = explain_landmarks([driver.fit for driver in seen], points, deltas, model, settings)
    weights = np.minimum(explanation.weights @ together, RetargetSettings.strongest)
    explanation = replace(explanation, weights=within_reach(weights, rig.names))
    return Retargeting(rig, model.template, explanation, "mm" if meshes else "percent")
