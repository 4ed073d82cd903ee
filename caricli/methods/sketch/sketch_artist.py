"""Draws whole sketches of heads of one topology."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from caricli.geometry.alignment.head_rotation import head_angles
from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.methods.sketch.draw_sketch import draw_curves, framing_camera
from caricli.methods.sketch.outline import head_outline
from caricli.methods.sketch.suggestive_contours import ContourFinder, ContourSettings, runs
from caricli.render.visibility.seen_points import seen_points
from caricli.structures.camera import Camera
from caricli.structures.sketch import CANVAS, Sketch, Stroke, StrokeKind
from caricli.template.annotation import EARS
from caricli.template.feature_curves import FeatureCurve, feature_curves
from caricli.template.template import Template

WRINKLED = (
    *("face", "forehead", "chin", "cheek_left", "cheek_right", "temple_left", "temple_right", "nose", "mouth"),
    *("brow_left", "brow_right"),
)
"""Regions where lines are wrinkles: the dark gray of figure 3 of the sketch paper."""

DRAWN_BY_CURVES = (
    *("eyes_left", "eyes_right", "eye_socket_left", "eye_socket_right", "lips", "inner_mouth", "nostril_left"),
    *("nostril_right", "ear_left", "ear_right", "neck", "scalp"),
)
"""Regions that the curves draw already, or nobody draws."""


@dataclass(frozen=True)
class ArtistSettings:
    """What is drawn. Lengths are of the mesh's height.

    contours: ContourSettings. front: degrees of yaw or pitch up to which the silhouette is the annotated curve; beyond,
    it is the outline of the head as the view has it, and what is hidden of the other curves is left out. beside: how
    near to the silhouette a wrinkle is left out, for there it is only its double; near: the same for other curves.
    buried: how deep in the surface a point of a curve may lie and be seen; most: wrinkles.
    """

    contours: ContourSettings = ContourSettings()
    front: float = 12.0
    beside: float = 0.035
    near: float = 0.012
    buried: float = 0.02
    most: int = 40


class SketchArtist:
    """Draws sketches of shapes of one template; what no shape changes is prepared once."""

    def __init__(self, template: Template, settings: ArtistSettings | None = None) -> None:
        """template: Template. settings: ArtistSettings. A head whose annotation has no regions gets no wrinkles."""
        self.settings = settings or ArtistSettings()
        self.template = template
        self.curves: tuple[FeatureCurve, ...] = feature_curves(template.annotation)
        region = template.mask(*WRINKLED) & ~template.mask(*DRAWN_BY_CURVES)
        self.finder = ContourFinder(template, region, self.settings.contours)

    def camera(self, vertices: np.ndarray, view: tuple[float, float] = (0.0, 0.0), side: int = CANVAS) -> Camera:
        """The camera that sees all that is drawn in the middle of a square canvas.

        vertices: (V, 3) metres. view: yaw and pitch of the head in degrees; a positive yaw looks to the right of the
        picture, a positive pitch down. side: pixels.
        """
        drawn = vertices[~self.template.mask("neck")]
        return framing_camera(drawn, view, side)

    def draw(
        self, vertices: np.ndarray, camera: Camera, size: tuple[int, int] = (CANVAS, CANVAS), wrinkles: bool = True
    ) -> Sketch:
        """The Sketch of a shape.

        vertices: (V, 3) metres. camera: Camera. size: (width, height) of the canvas, pixels. wrinkles: whether lines
        are drawn beside silhouette and features.
        """
        turn = np.degrees(head_angles(camera.rotation))
        if np.abs(turn[:2]).max() <= self.settings.front:
            strokes = draw_curves(vertices, self.curves, camera)
        else:
            strokes = (*self._outline(vertices, camera, size), *self._seen_curves(vertices, camera))
        further = [stroke for _, stroke in self._wrinkles(vertices, camera, strokes)] if wrinkles else []
        return Sketch((*strokes, *further), size)

    def _outline(self, vertices: np.ndarray, camera: Camera, size: tuple[int, int]) -> list[Stroke]:
        neck = self.template.mask("neck", *EARS, "inner_mouth")
        faces = self.template.faces
        points = head_outline(camera.place(vertices), faces[~neck[faces].any(1)], size)
        return [] if points is None else [Stroke(points, StrokeKind.SILHOUETTE)]

    def _seen_curves(self, vertices: np.ndarray, camera: Camera) -> list[Stroke]:
        """Strokes of what is seen of the curves but the silhouette; one that is seen whole keeps its name."""
        curves = [curve for curve in self.curves if curve.kind is not StrokeKind.SILHOUETTE]
        placed = camera.place(vertices)
        tolerance = self.settings.buried * float(np.ptp(vertices[:, 1])) * camera.scale
        strokes = []
        for curve in curves:
            points = placed[curve.vertices]
            seen = seen_points(points, placed, self.template.faces, tolerance)
            for start, end in runs(seen):
                name = curve.name if end - start == len(points) else None
                strokes.append(Stroke(points[start:end, :2], curve.kind, name))
        return strokes

    def wrinkle_lines(self, vertices: np.ndarray, camera: Camera, count: int) -> list[np.ndarray]:
        """The strongest wrinkle lines (N, 3) on the surface, metres, ``count`` at most; arguments as of ``draw``."""
        strokes = draw_curves(vertices, self.curves, camera)
        return [points for points, _ in self._wrinkles(vertices, camera, strokes)[:count]]

    def _wrinkles(
        self, vertices: np.ndarray, camera: Camera, strokes: tuple[Stroke, ...]
    ) -> list[tuple[np.ndarray, Stroke]]:
        """Wrinkles beside strokes, each as points (N, 3) of the surface and as it is drawn."""
        unit = float(np.ptp(vertices[:, 1])) * camera.scale
        shortest = self.settings.contours.shortest * unit
        near = {
            StrokeKind.SILHOUETTE: self.settings.beside * unit,
            StrokeKind.FEATURE: self.settings.near * unit,
            StrokeKind.WRINKLE: self.settings.near * unit,
        }
        trees = [(KDTree(_sampled(stroke.points, shortest / 4)), near[stroke.kind]) for stroke in strokes]
        wrinkles: list[tuple[np.ndarray, Stroke]] = []
        for line in self.finder.lines(vertices, camera):
            points = camera.project(line.points)
            free = np.ones(len(points), bool)
            for tree, distance in trees:
                free &= tree.query(points, distance_upper_bound=distance)[0] > distance
            pieces = [(line.points[a:b], Stroke(_smoothed(points[a:b]), StrokeKind.WRINKLE)) for a, b in runs(free)]
            long = [(there, piece) for there, piece in pieces if piece.length > shortest]
            wrinkles += long
            trees += [(KDTree(piece.points), near[StrokeKind.WRINKLE]) for _, piece in long]
            if len(wrinkles) >= self.settings.most:
                break
        return wrinkles[: self.settings.most]


def _sampled(points: np.ndarray, step: float) -> np.ndarray:
    """Points (M, 2) along a line (N, 2), at most a step apart."""
    along = arc_lengths(points)
    if along[-1] <= 0:
        return points[:1]
    places = np.linspace(0, along[-1], int(np.ceil(along[-1] / max(step, 1e-6))) + 1)
    return np.column_stack([np.interp(places, along, points[:, axis]) for axis in (0, 1)])


def _smoothed(points: np.ndarray, rounds: int = 3) -> np.ndarray:
    """A line (N, 2) without the corners of triangles; its ends stay."""
    for _ in range(rounds):
        points = np.vstack([points[:1], (points[:-2] + 2 * points[1:-1] + points[2:]) / 4, points[-1:]])
    return points
