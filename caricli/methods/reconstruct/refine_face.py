"""A face aligned exactly with the landmarks of its picture (portrait paper, section 3.2.2)."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation
from caricli.geometry.lines.slide_contour import slide_contour
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.reconstruct.settings import RefineSettings
from caricli.models.shape_model import ShapeModel
from caricli.structures import Camera, Face
from caricli.structures.landmarks import JAW, LID_PAIRS, LIP_PAIRS, MOUTH_CORNERS, PARTS
from caricli.template.template import Template

_MEETING = (*LID_PAIRS, *LIP_PAIRS)
"""Upper and lower landmarks that may be in one place, but not pass each other."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """A refined face and what changed.

    face: Face with the landmarks where they project to; its residual is not known, see ``face_of``.
    anchors: (L,) vertex ids that the landmarks stand on.
    before, after: percent of the diagonal of the given landmarks, mean errors by part of the face, and "all".
    moved: metres, the longest way of a vertex.
    flipped: share of triangles that are turned over.
    """

    face: Face
    anchors: np.ndarray
    before: dict[str, float]
    after: dict[str, float]
    moved: float
    flipped: float

    def face_of(self, model: ShapeModel) -> Face:
        """The face with the latent that it had, and as its residual all that this cannot express.

        model: of the latent; a face without one stays without, and is of no model.
        """
        if self.face.latent is None:
            return self.face.without_latent()
        return encode_face(self.face, model)

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        return {"before": self.before, "after": self.after, "moved": self.moved, "flipped": self.flipped}

    def describe(self) -> str:
        """What is printed of it."""
        errors = f"NME {self.before['all']:.2f} to {self.after['all']:.3f} %"
        return f"{errors}, flipped {100 * self.flipped:.3f} %, moved at most {1000 * self.moved:.1f} mm"


def refine_face(
    face: Face,
    points: np.ndarray,
    template: Template,
    settings: RefineSettings = RefineSettings(),  # noqa: B008 (frozen)
    spreads: np.ndarray | None = None,
) -> Refinement:
    """Move the landmarks' vertices onto their landmarks in the picture, at their depth, and the surface along.

    Jaw landmarks stand where the outline is. Mouth cavity and eye sockets stay behind the skin. A landmark with a
    spread S is met by the share E (E + S)^-1 of the way, E the square of half of the landmarks' usual distance from the
    face: as far as the landmark is surer than the face is.

    face: Face with the camera of the picture. points: (L, 2) pixels, NaN where unknown. template: Template of the
    face's topology. settings: RefineSettings. spreads: (L, 2, 2) covariances of the points' errors, square pixels, or
    None where they are to be met exactly.
    Returns Refinement. Raises InputError when the face has no camera, and when the landmarks are not of its picture or
    contradict each other.
    """
    camera = face.require_camera()
    target = _Target(points, _anchors(face.vertices, camera, template, len(points)), camera, settings)
    own = camera.project(face.vertices[target.anchors])
    before = target.errors(own)
    if before["all"] > 100 * settings.farthest:
        raise InputError(
            f"expected landmarks of the picture that the face was fitted to, found them {before['all']:.0f} % of their "
            "extent away on average"
        )
    ids, places = target.places(face.vertices, own, spreads)
    vertices = _deformed(face, template, ids, places, settings)
    landmarks = camera.project(vertices[target.anchors])
    return Refinement(
        face=replace(face.with_vertices(vertices), landmarks=landmarks, residual=None),
        anchors=target.anchors,
        before=before,
        after=target.errors(landmarks),
        moved=float(np.linalg.norm(vertices - face.vertices, axis=1).max()),
        flipped=float(flipped_triangles(vertices, template.gradients).mean()),
    )


def _anchors(vertices: np.ndarray, camera: Camera, template: Template, count: int) -> np.ndarray:
    """(L,) vertex ids that the first landmarks stand on, where paths do not meet each on one of its own."""
    note = template.annotation
    if count not in (68, len(note.landmarks)):
        raise InputError(f"expected 68 or {len(note.landmarks)} landmarks, found {count}")
    marked = note.landmarks[: len(JAW)]
    jaw = slide_contour(vertices, camera.rotation, template.vertices, marked, note.jaw_paths)
    taken: set[int] = set()
    # Where paths meet two landmarks can slide to one vertex; then the one nearer to the chin stops before it.
    for k in np.argsort(-np.abs(np.arange(len(JAW)) - len(JAW) // 2), kind="stable"):
        jaw[k] = _free(note.jaw_paths[k].tolist(), jaw[k], marked[k], taken)
        taken.add(int(jaw[k]))
    return np.concatenate([jaw, note.landmarks[len(JAW) : count]])


def _free(path: list[int], slid: int, marked: int, taken: set[int]) -> int:
    """The first vertex of a path, from where a landmark slid to back to where it was marked, that is not taken."""
    start, end = path.index(slid), path.index(marked)
    way = path[end : start + 1][::-1] if start > end else path[start : end + 1]
    return next((vertex for vertex in way if vertex not in taken), marked)


def _deformed(
    face: Face, template: Template, ids: np.ndarray, places: np.ndarray, settings: RefineSettings
) -> np.ndarray:
    """Vertices (V, 3) with those of ids (K,) at their places (K, 3), sound and with the pockets behind the skin."""

    def move(shape: np.ndarray) -> np.ndarray:
        surface = LaplacianDeformation(shape, template.faces, ids, settings.weight, settings.laplacian)
        return surface.move(places, settings.rounds)

    moved = move(face.vertices)
    # What nothing pulls at stays as it is, flipped triangles and all.
    if np.abs(moved - face.vertices).max() < settings.still * template.height:
        return moved
    sound = untangle(moved, template.gradients)
    if sound is not moved:
        moved = move(sound)
    return template.cavities.tuck(moved)


class _Target:
    """Landmarks of a picture that a face is to meet, and what contradicts that."""

    def __init__(self, points: np.ndarray, anchors: np.ndarray, camera: Camera, settings: RefineSettings) -> None:
        """points: (L, 2) pixels, NaN where unknown. anchors: (L,) vertex ids."""
        self.points = points
        self.anchors = anchors
        self.camera = camera
        self.settings = settings
        self.ids = np.flatnonzero(np.isfinite(points).all(axis=1))
        self.diagonal = float(np.linalg.norm(np.ptp(points[self.ids], axis=0)))

    def errors(self, landmarks: np.ndarray) -> dict[str, float]:
        """Mean distances of landmarks (L, 2) in percent of the diagonal by part of the face, where any is known."""
        distances = 100 * np.linalg.norm(landmarks - self.points, axis=1) / self.diagonal
        parts = {name: distances[[k for k in ids if k < len(distances)]] for name, ids in PARTS.items()}
        means = parts | {"all": distances}
        return {name: float(np.nanmean(part)) for name, part in means.items() if np.isfinite(part).any()}

    def places(
        self, vertices: np.ndarray, own: np.ndarray, spreads: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distinct vertices (K,) and where they are to be (K, 3), at the depth that they have.

        own: (L, 2) pixels, where the face's landmarks are. spreads: (L, 2, 2) square pixels, or None.
        Raises InputError for landmarks that contradict each other.
        """
        self._check_apart()
        points = self._meeting(own)
        if spreads is not None:
            gaps = points - own
            usual = np.nanmedian((gaps**2).sum(1)) / 2 + (self.settings.same * self.diagonal) ** 2
            shares = usual * np.linalg.inv(usual * np.eye(2) + np.nan_to_num(spreads))
            points = own + np.einsum("lab,lb->la", shares, gaps)
        ids, pixels = self._distinct(points)
        return ids, self.camera.lift(pixels, vertices[ids])

    def _check_apart(self) -> None:
        """Refuse two landmarks in one place, but those that meet on a closed eye or mouth."""
        near = np.linalg.norm(self.points[:, None] - self.points, axis=-1) < self.settings.same * self.diagonal
        for a, b in np.argwhere(np.triu(near, 1)).tolist():
            if (a, b) not in (*_MEETING, *MOUTH_CORNERS):
                raise InputError(f"expected landmarks in different places, found {a} and {b} in one")

    def _meeting(self, own: np.ndarray) -> np.ndarray:
        """Landmarks (L, 2) whose lids and lips that have passed each other meet half-way; far ones are refused.

        Lids and lips that overlap as far in the face's own (L, 2) stay as they are.
        """
        points = np.array(self.points)
        up = self.camera.rotation[:2, 1]
        up = up / (np.linalg.norm(up) * self.diagonal)
        for upper, lower in _MEETING:
            passed, before = (float((pixels[lower] - pixels[upper]) @ up) for pixels in (points, own))
            if abs(passed - before) < self.settings.same:
                continue
            slip = self.settings.lips_crossed if upper in PARTS["mouth"] else self.settings.crossed
            if passed > max(before, 0) + slip:
                message = "expected the upper above the lower, found them crossed"
                raise InputError(f"landmarks {upper} and {lower}: {message}")
            if passed > 0:
                points[[upper, lower]] = points[[upper, lower]].mean(0)
        return points

    def _distinct(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Anchors without repeats and their pixels; one that two landmarks want in different places is refused."""
        ids = self.anchors[self.ids]
        targets = points[self.ids]
        kept, first, row = np.unique(ids, return_index=True, return_inverse=True)
        apart = np.linalg.norm(targets - targets[first][row], axis=1)
        if apart.max() > self.settings.crossed * self.diagonal:
            worst = int(apart.argmax())
            wanted = f"vertex {ids[worst]} wanted in two, {apart[worst]:.0f} pixels apart"
            raise InputError(f"expected one place for every vertex, found {wanted}")
        return kept, targets[first]
