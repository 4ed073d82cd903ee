"""Coarse and refined reconstructions of portraits side by side (portrait paper, section 4.2)."""

import time
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from caricli.data.albedo import AlbedoPainter, random_look
from caricli.errors import CaricliError
from caricli.geometry.head_rotation import TURNS, head_rotation
from caricli.geometry.similarity import similarity
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.refine_face import refine_face
from caricli.methods.reconstruct.settings import MorphableWeights
from caricli.render.blend import over
from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.shade import Look, shade
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Camera, Face
from caricli.structures.landmarks import PARTS
from caricli.template.fine_mesh import fine_mesh

COARSE = {
    "morphable": ("morphable", fit_morphable),
    "elastic": ("intrinsic", fit_landmarks, "intrinsic"),
    "deformable": ("deformable", fit_landmarks, "latent"),
}
"""Coarse methods: kind of the model, the fit and its arguments after landmarks and model."""

REFINED = " + refine"
ADJUSTED = "adjust exp", "adjust id+exp"
METHODS = (*(f"{name}{end}" for name in COARSE for end in ("", REFINED)), *ADJUSTED)

PAPER_SIDE = 224
"""Pixels of the pictures that the paper's network takes."""

_UNBOUND = MorphableWeights(MorphableWeights.identity / 100, MorphableWeights.expression / 100)
_FILLED, _ASIDE = (0.7, 0.85), 0.03


@dataclass(frozen=True, eq=False)
class Portrait:
    """name; image (H, W, 3) uint8; points (L, 2) pixels, NaN where unknown; where they are known, mask (H, W) bool, the
    head, truth (V, 3) metres, and its pose."""

    name: str
    image: np.ndarray
    points: np.ndarray
    mask: np.ndarray | None = None
    truth: np.ndarray | None = None
    pose: Camera | None = None


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """A face and how well it fits.

    face: Face with the camera of the picture and the landmarks where they project to.
    errors: percent of the diagonal of the given landmarks, mean distances to these by part and "all".
    flipped: share of triangles that are turned over.
    seconds: a refinement's with those of what it refines.
    """

    face: Face
    errors: dict
    flipped: float
    seconds: float


class PortraitStudio:
    """Pictures of known faces: random colours in soft light before a random background."""

    def __init__(self, template, size):
        """template: Template of the faces. size: pixels, width and height of a picture."""
        self.template, self.size, self.fine = template, size, fine_mesh(template, 1)
        corners = (self.fine.weights @ template.vertices)[self.fine.mesh.faces]
        grain = np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2))
        self.painter = AlbedoPainter(template, self.fine.weights, float(grain))

    def portray(self, name, vertices, generator, noise=0.0):
        """Draw a face in a random pose, its landmarks where its vertices are seen, those of the jaw on the outline.

        name: of the Portrait. vertices: (V, 3) metres. generator: numpy Generator. noise: standard deviation of the
        landmarks' coordinates, percent of their diagonal.
        Returns Portrait.
        """
        pose = self._pose(vertices, generator)
        colours = 255 * self.painter.draw(random_look(generator))
        camera = pose.place(vertices)
        faces = self.template.faces
        seen = self.fine.weights @ sky_visibility(vertices, faces, smooth_normals(vertices, faces))
        balls = place_eyeballs(self.template.with_vertices(vertices), self.template.annotation)
        look = Look(
            vertex_colours=colours,
            eyeballs=[(pose.place(centre), pose.scale * radius) for centre, radius in balls],
            gaze=pose.rotation[:, 2],
            visibility=seen.astype(np.float32),
            rotation=pose.rotation,
        )
        drawn = shade(self.fine.weights @ camera, self.fine.mesh.faces, self.size, self.size, look)
        points = pose.project(vertices[landmark_vertices(vertices, pose.rotation, self.template, 68)])
        points += noise / 100 * np.linalg.norm(np.ptp(points, axis=0)) * generator.normal(size=points.shape)
        image = over(drawn, self._background(generator))
        return Portrait(name, image, points, drawn[..., 3] > 127, vertices, pose)

    def _pose(self, vertices, generator):
        rotation = head_rotation(generator.uniform(-1, 1, 3) * TURNS)
        flat = vertices @ rotation[:2].T
        scale = generator.uniform(*_FILLED) * self.size / np.ptp(flat, axis=0).max()
        middle = self.size * (0.5 + generator.uniform(-_ASIDE, _ASIDE, 2))
        return Camera(float(scale), rotation, middle - scale * (flat.min(0) + flat.max(0)) / 2)

    def _background(self, generator):
        """Plain, or cloudy and grainy."""
        plain = np.broadcast_to(generator.uniform(0, 255, 3), (self.size, self.size, 3))
        if generator.random() < 0.5:
            return np.round(plain).astype(np.uint8)
        coarse = generator.uniform(-80, 80, (6, 6, 3))
        clouds = cv2.resize(coarse, (self.size, self.size), interpolation=cv2.INTER_CUBIC)
        grains = generator.normal(0, 12, plain.shape)
        return np.clip(np.round(plain + clouds + grains), 0, 255).astype(np.uint8)


def reconstruct_portrait(points, models):
    """Reconstruct a face by every one of METHODS.

    "adjust exp" and "adjust id+exp" are equation 7, the former with the mean identity; it has no regularisation, and a
    hundredth of equation 6 keeps it solvable.

    points: (L, 2) pixels, NaN where unknown. models: by kind.
    Returns dict from METHODS to Reconstruction, and dict from those that refused the landmarks to what they said.
    Raises InputError, NumericsError.
    """
    found, refused = {}, {}
    for name, (kind, fit, *how) in COARSE.items():
        model = models[kind]
        coarse = found[name] = _timed(partial(fit, points, model, *how))
        start = time.perf_counter()
        try:
            fine = refine_face(coarse.face, points, model.template)
        except CaricliError as error:
            refused[name + REFINED] = str(error)
            continue
        seconds = coarse.seconds + time.perf_counter() - start
        found[name + REFINED] = Reconstruction(fine.face, fine.after, fine.flipped, seconds)
    morphable = models["morphable"]
    for name, kept in zip(ADJUSTED, (np.zeros(len(morphable.identity)), None), strict=True):
        found[name] = _timed(partial(fit_morphable, points, morphable, _UNBOUND, kept))
    return found, refused


def _timed(fitting):
    """Reconstruction of the LandmarkFit that a function returns."""
    start = time.perf_counter()
    fit = fitting()
    seconds = time.perf_counter() - start
    errors = fit.part_errors | {"all": fit.nme}
    return Reconstruction(fit.face, errors, fit.flipped, seconds)


def measure_portrait(found, portrait, template):
    """Figures of a Reconstruction, as JSON.

    nme: its errors. pixels: the paper's sum of distances in a picture of PAPER_SIDE pixels. shape, where the truth is
    known: mean distance of the vertices of the face after a similarity alignment of them, in percent of the head's
    height. flipped: percent of triangles. seconds.
    """
    known = np.isfinite(portrait.points).all(1)
    diagonal = np.linalg.norm(np.ptp(portrait.points[known], axis=0))
    scale = diagonal / 100 * PAPER_SIDE / max(portrait.image.shape[:2])
    counts = {name: known[[k for k in ids if k < len(known)]].sum() for name, ids in PARTS.items()}
    counts["all"] = known.sum()
    figures = {
        "nme": found.errors,
        "pixels": {name: float(scale * counts[name] * error) for name, error in found.errors.items()},
        "flipped": 100 * found.flipped,
        "seconds": found.seconds,
    }
    if portrait.truth is not None:
        face = template.region("face")
        ours, true = found.face.vertices[face], portrait.truth[face]
        scale, rotation, translation = similarity(ours, true)
        distances = np.linalg.norm(scale * ours @ rotation.T + translation - true, axis=1)
        figures["shape"] = float(100 * distances.mean() / np.ptp(portrait.truth[:, 1]))
    return figures


def mean_figures(faces):
    """Means over the faces that have a figure. faces: list of dicts from METHODS to figures. Returns such a dict."""
    names = [name for name in METHODS if any(name in face for face in faces)]
    return {name: _mean([face[name] for face in faces if name in face]) for name in names}


def _mean(rows):
    keys = dict.fromkeys(key for row in rows for key in row)
    columns = {key: [row[key] for row in rows if key in row] for key in keys}
    return {key: _mean(c) if isinstance(c[0], dict) else float(np.mean(c)) for key, c in columns.items()}


def refinement_gains(faces):
    """What refining did to the 3D errors, of faces that were refined. faces: list of dicts from METHODS to figures.

    Returns dict from names of coarse methods to faces, better (on how many it is lower), before and after (means).
    """
    gains = {}
    for name in COARSE:
        pairs = [(face[name]["shape"], face[name + REFINED]["shape"]) for face in faces if name + REFINED in face]
        if pairs:
            before, after = np.array(pairs).T
            count = {"faces": len(pairs), "better": int((after < before).sum())}
            gains[name] = count | {"before": float(before.mean()), "after": float(after.mean())}
    return gains
