"""A sketch to a face: first one that is likely for it, then the lines are followed (sketch paper, section 5.1)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.geometry.lines.match_line import resample
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.limits import MAX_SKETCH_POINTS
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.sketch.fit_lines import Lines, TooFewLines
from caricli.methods.sketch.follow_lines import LineFollower
from caricli.methods.sketch.line_handles import LineHandles, lines_by_curve
from caricli.methods.sketch.model_coarse import CoarseFace, model_coarse
from caricli.methods.sketch.name_strokes import name_strokes
from caricli.methods.sketch.network_coarse import network_coarse
from caricli.methods.sketch.settings import ELASTIC, FollowSettings
from caricli.methods.sketch.sides_exchanged import sides_exchanged
from caricli.methods.sketch.strokes_read import Read
from caricli.methods.sketch.unsure_share import unsure_share
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.structures.sketch import Sketch, Stroke, StrokeKind
from caricli.template.feature_curves import named_curves

_SPACING = 0.004
"""Of the canvas, or of twice a smaller face: between points at which lines are compared."""
_UNSURE = 0.5
"""Share of strokes from which on it is said that they draw no face."""

_CONTRADICTS = (0.3, 1.0)
"""Percent of the canvas: a curve that was followed and is farther from its lines was taken for the wrong one; from the
first on where it was nearer before."""
_ROUNDS = 3
"""Curves that are given up, at most."""

Coarse = Callable[[Sketch, Lines, LineHandles], CoarseFace]
"""A face that is likely for a sketch, with camera and latent: of the sketch, its lines by curves, and the handles."""


@dataclass(frozen=True, eq=False)
class SketchFit:
    """A face and how near its curves come to the lines of its sketch.

    face: Face with camera, landmarks, latent and residual. sketch: Sketch with the names of the curves that its strokes
    draw. curves: (M, 2) pixels by names: all curves of the face as its camera sees them. coarse, errors: percent of the
    longer side of the canvas, mean distances of the drawn lines from the curves by their names, and "all", before they
    were followed and after. worst: the same, the largest distance. flipped: share of triangles that are turned over.
    prior_rms: root mean square of the whitened latent before lines were followed, about 1 for a typical face. share: of
    the way to the lines. asked: the share that was asked for, more than ``share`` where that would tear the surface.
    unsure: share of the strokes that do not say what they draw and seem to draw no line of a face. doubted: mean
    distance of the likeliest face from the lines, percent of the canvas, from which on it is doubtful that they show
    one. begun: with what, of COARSE, or ELASTIC. exchanged: see ``sides_exchanged``. unlikely: whether the face is more
    unusual than any that is meant. left: curves whose strokes were left again, because no face that meets the others
    comes near them.
    """

    face: Face
    sketch: Sketch
    curves: dict[str, np.ndarray]
    coarse: dict[str, float]
    errors: dict[str, float]
    worst: float
    flipped: float
    prior_rms: float
    share: float
    asked: float
    unsure: float
    doubted: float
    begun: str
    exchanged: bool
    unlikely: bool
    left: tuple[str, ...] = ()

    @property
    def strange(self) -> bool:
        """Whether the likeliest face is so far from the lines that it is doubtful whether they show one."""
        return self.coarse["all"] > self.doubted

    @property
    def scale(self) -> float:
        """What distances in percent of the canvas are doubted by, 1 where the face takes half of it or more."""
        return _scale(self.curves, max(self.sketch.size))

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        return {
            "coarse": self.begun,
            "line_errors_before": self.coarse,
            "line_errors": self.errors,
            "worst_line_error": self.worst,
            "flipped": self.flipped,
            "followed": self.share,
            "strange": self.strange,
            "prior_rms": self.prior_rms,
            "unsure": self.unsure,
            "unlikely": self.unlikely,
            "sides_exchanged": self.exchanged,
            "left": list(self.left),
            "strokes": [{"kind": str(stroke.kind), "curve": stroke.curve} for stroke in self.sketch.strokes],
        }

    def describe(self) -> str:
        """What is printed of it."""
        lines = f"lines {self.coarse['all']:.2f} to {self.errors['all']:.3f} % of the canvas away"
        told = [f"{lines}, prior {self.prior_rms:.2f}, flipped {100 * self.flipped:.3f} %"]
        if self.begun == ELASTIC:
            told.append("begun with an elastic face, as no usual one comes near the lines")
        if self.strange:
            told.append("doubtful: so far from any face lines are of something else")
        if self.errors["all"] > self.coarse["all"]:
            told.append("doubtful: following the lines took the face farther from them")
        if self.exchanged:
            told.append("doubtful: its left and right lie as if exchanged; they are the subject's")
        if self.unlikely:
            told.append("doubtful: more unusual than any face that is meant, so some lines were taken for others")
        if self.unsure > _UNSURE:
            told.append(f"doubtful: {100 * self.unsure:.0f} % of the strokes without a name are no lines of a face")
        if self.left:
            told.append(f"doubtful: what looked like {', '.join(self.left)} goes with no other line, and was left")
        if self.share != self.asked:
            told.append(f"doubtful: followed for {100 * self.share:.3g} % of the way, farther the surface would tear")
        return "; ".join(told)


def _contradicting(sketch: Sketch, fit: SketchFit) -> str | None:
    """The curve that is farthest from its lines though they were followed, where a stroke of the sketch did not say
    itself that it draws it; None where all are met."""
    if fit.share < 1:
        return None
    said = {stroke.curve for stroke in sketch.strokes}
    guessed = {curve: error for curve, error in fit.errors.items() if curve != "all" and curve not in said}
    least, most = (fit.scale * bound for bound in _CONTRADICTS)
    far = {
        curve: error
        for curve, error in guessed.items()
        if error > most or (error > least and error > fit.coarse[curve])
    }
    return max(far, key=lambda curve: far[curve]) if far else None


def _without(named: Sketch, curve: str, sketch: Sketch) -> Sketch:
    """A named sketch whose strokes of a curve are left, each of the kind of the stroke of the sketch without names that
    it has most points in common with, of several the one of fewest points; of unknown kind where it has none."""
    drawn = [({point.tobytes() for point in stroke.points}, stroke.kind) for stroke in sketch.strokes]

    def left(stroke: Stroke) -> Stroke:
        own = {point.tobytes() for point in stroke.points}
        points, kind = max(drawn, key=lambda each: (len(own & each[0]), -len(each[0])))
        return replace(stroke, curve=None, kind=kind if own & points else StrokeKind.UNKNOWN)

    return named.with_strokes(left(stroke) if stroke.curve == curve else stroke for stroke in named.strokes)


class SketchReconstruction:
    """From sketches to faces of one model; what does not depend on a sketch is solved once.

    model: ShapeModel. handles: LineHandles of its template.
    """

    @classmethod
    def of(
        cls,
        encoder: LandmarkEncoder,
        see: Callable[[Sketch], Face] | None = None,
        read: Read | None = None,
    ) -> "SketchReconstruction":
        """Faces of the model of a LandmarkEncoder that begin with what a network sees, or else with the model.

        see, read: what strokes without names are told by, see ``name_strokes``.
        """
        if see is None:
            return cls(encoder.model, partial(model_coarse, encoder=encoder), read=read)
        return cls(encoder.model, partial(network_coarse, see=see, encoder=encoder), see=see, read=read)

    def __init__(
        self,
        model: ShapeModel,
        coarse: Coarse,
        settings: FollowSettings = FollowSettings(),  # noqa: B008 (frozen)
        see: Callable[[Sketch], Face] | None = None,
        read: Read | None = None,
    ) -> None:
        """coarse: gives the face that lines are followed from, in the topology of the model. see, read: what strokes
        without names are told by, see ``name_strokes``.

        Raises InputError for a model whose annotation names no curves.
        """
        self.model = model
        self.handles = LineHandles(named_curves(model.template.annotation))
        self.follower = LineFollower(model.template, self.handles, settings)
        self._see = see
        self._read = read
        self._coarse = coarse
        self._settings = settings

    def reconstruct(self, sketch: Sketch, share: float = 1.0) -> SketchFit:
        """The face of a sketch.

        share: of the way from the likely face to the lines, 0 to 1. Raises InputError where nothing can be told.
        """
        named = name_strokes(sketch, self.handles, self.model, see=self._see, read=self._read)
        fit = self._fit(sketch, named, share)
        for _ in range(_ROUNDS):
            curve = _contradicting(sketch, fit)
            if curve is None:
                break
            named = _without(named, curve, sketch)
            try:
                fit = replace(self._fit(sketch, named, share), left=(*fit.left, curve))
            except TooFewLines:  # those that contradict each other show a face, at least
                break
        return fit

    def _fit(self, sketch: Sketch, named: Sketch, share: float) -> SketchFit:
        """The face whose curves lie on the strokes that name them."""
        unsure = unsure_share(sketch, named, self.handles)
        lines = lines_by_curve(named)
        coarse, begun = self._coarse(named, lines, self.handles)
        camera = coarse.require_camera()
        before = self._curves(coarse)
        places = self.handles.places(lines, camera.project(coarse.vertices[self.handles.vertices]))
        face, followed = self._sound(coarse, places, share)
        likely = _means(_distances(lines, before, max(sketch.size)))
        # What is far from its lines is doubted as such; the rest of a scribble may lie near to a face by chance.
        doubted = self._settings.strange * _scale(before, max(sketch.size))
        if unsure > _UNSURE and share and not followed and likely["all"] <= doubted:
            raise InputError("expected lines of a face, found most of them none of it and the others tearing it apart")
        prior_rms = float(self.model.prior.rms(coarse.require_latent()))
        landmarks = camera.project(face.vertices[self.model.template.annotation.landmarks])
        after = self._curves(face)
        distances = _distances(lines, after, max(sketch.size))
        return SketchFit(
            face=replace(encode_face(face, self.model), landmarks=landmarks),
            sketch=named,
            curves=after,
            coarse=likely,
            errors=_means(distances),
            worst=max((float(each.max()) for each in distances.values()), default=0.0),
            flipped=self._flipped(face),
            prior_rms=prior_rms,
            unlikely=prior_rms > self._settings.unlikely,
            exchanged=sides_exchanged(sketch),
            share=followed,
            asked=share,
            unsure=unsure,
            doubted=doubted,
            begun=begun,
        )

    def _sound(self, coarse: Face, places: np.ndarray, share: float) -> tuple[Face, float]:
        """A face with its handles as far of the way to places (H, 2) as its surface allows, and how far that is.

        Raises InputError where even the coarse face stays torn.
        """
        for step in self._settings.steps:
            followed = step * share
            moved = self._followed(coarse, places, followed) if followed else self._untangled(coarse.vertices)
            face = coarse.with_vertices(moved)
            flipped = self._flipped(face)
            if flipped <= self._settings.torn:
                return face, followed
        torn = f"{100 * flipped:.1f} % of its triangles turned over"
        raise InputError(f"expected lines that a face could show, found the likeliest one torn: {torn}")

    def _untangled(self, vertices: np.ndarray) -> np.ndarray:
        return untangle(vertices, self.model.template.gradients)

    def _flipped(self, face: Face) -> float:
        return float(flipped_triangles(face.vertices, self.model.template.gradients).mean())

    def _followed(self, face: Face, places: np.ndarray, share: float) -> np.ndarray:
        """Vertices (V, 3) of a face with its handles the share of the way to places (H, 2), sound, and with the pockets
        behind the skin."""
        template = self.model.template
        camera = face.require_camera()
        own = camera.project(face.vertices[self.handles.vertices])
        places = own + share * (places - own)
        moved = self.follower.follow(face.vertices, camera, places)
        if np.abs(moved - face.vertices).max() < self._settings.still * template.height:
            return moved
        sound = self._untangled(moved)
        if sound is not moved:
            # What this turns over again is repaired for good: lines may then be missed by a little.
            moved = self._untangled(self.follower.follow(sound, camera, places))
        return template.cavities.tuck(moved)

    def _curves(self, face: Face) -> dict[str, np.ndarray]:
        camera = face.require_camera()
        return {curve.name: camera.project(face.vertices[curve.vertices]) for curve in self.handles.curves}


def _scale(curves: dict[str, np.ndarray], side: float) -> float:
    """Twice the share of a canvas that the curves (M, 2) of a face take, at most 1. side: of the canvas."""
    return min(1.0, 2 * float(np.ptp(np.concatenate(list(curves.values())), axis=0).max()) / side)


def _distances(lines: Lines, curves: dict[str, np.ndarray], side: float) -> dict[str, np.ndarray]:
    """Distances of points along lines from the curves that they draw, percent of the side of the canvas."""
    spacing = _SPACING * side * _scale(curves, side)
    return {
        name: 100 / side * line_distances(_dense(several, spacing), [curves[name]]) for name, several in lines.items()
    }


def _dense(lines: Sequence[np.ndarray], spacing: float) -> np.ndarray:
    """Points (N, 2) along lines. spacing: of them, pixels; more where these would be more than a sketch may have."""
    lengths = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines]
    spacing = max(spacing, sum(lengths) / MAX_SKETCH_POINTS)
    counts = [max(2, int(length / spacing)) for length in lengths]
    return np.concatenate([resample(line, count) for line, count in zip(lines, counts, strict=True)])


def _means(distances: dict[str, np.ndarray]) -> dict[str, float]:
    everything = np.concatenate(list(distances.values())) if distances else np.zeros(1)
    return {name: float(each.mean()) for name, each in distances.items()} | {"all": float(everything.mean())}
