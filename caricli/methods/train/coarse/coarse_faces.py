"""Faces in pictures that the coarse network is trained on, with or without their truth, and windows around them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from caricli.data.albedo import vertex_painter
from caricli.data.dataset import Dataset
from caricli.data.picture_set import PictureSet
from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.pictures.sitter_shapes import sitter_shapes
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.train.detector.disguise_picture import disguise_window
from caricli.methods.train.detector.split_pictures import SplitPictures
from caricli.methods.train.detector.windows import (
    around_middle,
    bent_places,
    bent_window,
    mirrored,
    moved_window,
    random_bend,
)
from caricli.models.coarse.model import LANDMARKS, SHARE
from caricli.models.morphable.model import MorphableModel
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.landmarks import MIRRORED
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class TrueFace:
    """What is true of a face before the camera of a picture.

    vertices: (V, 3) float32 metres, in size and place as near to the model's mean as a similarity brings its face: a
    picture does not show these. albedo: (V, 3) float32 sRGB, 1 is white, unlit. anchors: (L,) vertices that its
    landmarks stand on. rotation: (3, 3) from these axes to the camera's.
    """

    vertices: np.ndarray
    albedo: np.ndarray
    anchors: np.ndarray
    rotation: np.ndarray

    def moved(self, window: "Moved", template: Template, mean: np.ndarray) -> "TrueFace":
        """The same in a window; what is stretched and bent is another face. mean: (F, 3) see ``in_place``."""
        linear = window.matrix[:, :2]
        turn = np.eye(3)
        turn[:2, :2] = linear / np.sqrt(abs(np.linalg.det(linear)))
        seen = self.vertices.astype(float) @ (turn @ self.rotation).T
        albedo = self.albedo
        anchors = self.anchors
        if np.linalg.det(linear) < 0:
            mirror = template.annotation.mirror
            assert mirror is not None
            seen = seen[mirror]
            albedo = albedo[mirror]
            anchors = mirror[anchors[list(MIRRORED)]]
        if window.bend is not None:
            seen[:, :2] += window.bent(seen[:, :2], anchors)
        vertices, rotation = in_place(seen, template, mean)
        return TrueFace(vertices, albedo, anchors, rotation.T)


@dataclass(frozen=True, eq=False)
class Moved:
    """How a picture became a window.

    matrix: (2, 3) affine map between their pixels. landmarks: (L, 2) pixels after it. bend: (S, S, 2) pixels, see
    ``random_bend``, or None.
    """

    matrix: np.ndarray
    landmarks: np.ndarray
    bend: np.ndarray | None

    def bent(self, flat: np.ndarray, anchors: np.ndarray) -> np.ndarray:
        """How far the bend moves vertices (V, 2), seen straight from before, metres as they are.

        anchors: (L,) vertices that the landmarks stand on, which tell how large a metre is.
        """
        assert self.bend is not None
        own = flat[anchors] - flat[anchors].mean(0)
        marks = self.landmarks - self.landmarks.mean(0)
        scale = (own * marks).sum() / (own**2).sum()
        places = scale * (flat - flat[anchors].mean(0)) + self.landmarks.mean(0)
        return (bent_places(places, self.bend) - places) / scale


def in_place(vertices: np.ndarray, template: Template, model_face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) float32 as near to those of the mean face (F, 3) as a similarity brings their face.

    Returns them and the rotation (3, 3) that did it.
    """
    face = template.region("face")
    scale, rotation, translation = similarity(vertices[face].astype(float), model_face)
    return (scale * vertices @ rotation.T + translation).astype(np.float32), rotation


@dataclass(frozen=True, eq=False)
class StudiedFace:
    """A face of a picture. picture: MarkedPicture with it alone. frame: where it is. truth: TrueFace, or None."""

    picture: MarkedPicture
    frame: FaceFrame
    truth: TrueFace | None


class FaceSource(Protocol):
    """Faces in pictures, by number."""

    @property
    def faces(self) -> Sequence:
        """As many as there are."""

    def study(self, number: int) -> StudiedFace:
        """One of them."""


class TrueFaces:
    """Faces of a PictureSet with what is true of them in a morphable model.

    The coefficients that the folder stores are of the model that it was made with. What is taken for true are the
    meshes of the dataset, with all that the sitters did, which ``sitter_shapes`` repeats, and their colours: so any
    model of the topology can be trained for. What it cannot express is left over in the distance of the vertices.
    """

    def __init__(self, pictures: PictureSet, dataset: Dataset, model: MorphableModel, split: str) -> None:
        """dataset: of whose people the pictures are. model: MorphableModel. split: name of that of the people.

        Raises InputError when pictures, dataset and model do not fit each other.
        """
        if not dataset.template.topology_id == model.template.topology_id == pictures.manifest.get("topology_id"):
            raise InputError("expected pictures, dataset and morphable model of one topology, found others")
        self.split = SplitPictures(pictures, split)
        self.faces = self.split.faces
        self.template = dataset.template
        sitters = sitter_shapes(pictures, dataset)
        self.mean = model.mean[model.template.region("face")]
        self.rows = {number: pictures.faces(number) for number in self.split.numbers}
        self.rotations = pictures.truth["rotation"].astype(float)
        self.places = sitters.places
        used = {int(self.places[self.rows[number][place]]) for number, place in self.faces}
        self.vertices = {place: sitters.vertices[place].copy() for place in used}
        painter = vertex_painter(dataset.template)
        self.albedos = {place: painter.draw(sitters.appearances[place]).astype(np.float32) for place in sorted(used)}

    def shapes(self) -> np.ndarray:
        """(K, V, 3) float32 all of them, each once, in the place of a TrueFace."""
        return np.stack(
            [in_place(self.vertices[place], self.template, self.mean)[0] for place in sorted(self.vertices)]
        )

    def study(self, number: int) -> StudiedFace:
        """One of the faces. Raises InputError when a file of its picture is missing or damaged."""
        picture, place = self.faces[number]
        marked = self.split.marked(picture)
        own = replace(marked, landmarks=marked.landmarks[[place]], visible=marked.visible[[place]])
        row = self.rows[picture][place]
        sitter = int(self.places[row])
        rotation = self.rotations[row]
        anchors = landmark_vertices(self.vertices[sitter].astype(float), rotation, self.template, LANDMARKS)
        vertices, turn = in_place(self.vertices[sitter], self.template, self.mean)
        truth = TrueFace(vertices, self.albedos[sitter], anchors, rotation @ turn.T)
        return StudiedFace(own, FaceFrame.of(own.landmarks[0]), truth)


class JoinedFaces:
    """Faces of several TrueFaces, numbered on from one to the next."""

    def __init__(self, parts: Sequence[TrueFaces]) -> None:
        """parts: at least one, all of one morphable model."""
        self.parts = parts
        self.faces = [(part, number) for part in parts for number in range(len(part.faces))]

    def shapes(self) -> np.ndarray:
        """(K, V, 3) float32 all of them, see TrueFaces."""
        return np.concatenate([part.shapes() for part in self.parts])

    def study(self, number: int) -> StudiedFace:
        """One of the faces. Raises InputError when a file of its picture is missing or damaged."""
        part, place = self.faces[number]
        return part.study(place)


@dataclass(frozen=True)
class CoarseWindowSettings:
    """How windows around faces are drawn: as near to the frame of the landmarks as a detector comes.

    shift: deviation of the face's centre, of its side. size: of its logarithm. turn: of its roll, radians. stretch: of
    what a linear map changes; bend: of what a smooth one moves, of the window's side, in ``bent`` of the windows. Both
    make other people of the few whose pictures there are. disguised: how many of the windows whose colours need not
    stay as they are have them changed.
    """

    shift: float = 0.03
    size: float = 0.04
    turn: float = 0.05
    stretch: float = 0.03
    bend: float = 0.02
    bent: float = 0.5
    disguised: float = 0.5


@dataclass(frozen=True, eq=False)
class CoarseWindow:
    """A window around a face.

    picture: MarkedPicture with pixels (S, S, 3) float32 from 0 to 1. truth: TrueFace, or None. plain: whether the
    pixels are neither disguised nor spoilt.
    """

    picture: MarkedPicture
    truth: TrueFace | None
    plain: bool


class WindowDrawer:
    """Draws windows around faces: upright but for a little, half of the time mirrored, stretched and bent."""

    def __init__(self, model: MorphableModel, size: int, settings: CoarseWindowSettings | None = None) -> None:
        """model: of the truth. size: pixels."""
        self.template = model.template
        self.mean = model.mean[model.template.region("face")]
        self.size = size
        self.settings = settings or CoarseWindowSettings()

    def draw(self, face: StudiedFace, plain: bool, generator: np.random.Generator) -> CoarseWindow:
        """Cut a face out. plain: whether colours stay as they are, else they may be changed and parts covered."""
        settings = self.settings
        matrix = self._matrix(face.frame, generator)
        window = moved_window(face.picture, matrix, self.size)
        bend = None
        if generator.random() < settings.bent:
            bend = random_bend(self.size, settings.bend, generator)
        moved = Moved(matrix, window.landmarks[0], bend)
        window = window if bend is None else bent_window(window, bend)
        truth = None if face.truth is None else face.truth.moved(moved, self.template, self.mean)
        if plain or generator.random() >= settings.disguised:
            window = replace(window, pixels=window.pixels.astype(np.float32) / 255)
        else:
            window = disguise_window(window, generator)
        return CoarseWindow(window, truth, plain)

    def _matrix(self, frame: FaceFrame, generator: np.random.Generator) -> np.ndarray:
        """(2, 3) a map to a window about the frame of a face."""
        settings = self.settings
        centre = frame.centre + settings.shift * frame.side * generator.normal(size=2)
        side = frame.side * np.exp(settings.size * generator.normal())
        matrix = FaceFrame(centre, side, frame.roll + settings.turn * generator.normal()).matrix(self.size, SHARE)
        stretch = np.eye(2) + settings.stretch * generator.normal(size=(2, 2))
        matrix = around_middle(stretch, self.size) @ np.vstack([matrix, [0, 0, 1]])
        mirrors = self.template.annotation.mirror is not None and generator.random() < 0.5
        return mirrored(matrix, self.size) if mirrors else matrix
