"""A whole picture: a background, people, what they hold, and what it is made with."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from caricli.methods.pictures.background import random_background
from caricli.methods.pictures.draw_sitter import Drawing, draw_sitter, random_strands
from caricli.methods.pictures.held import hold_before
from caricli.methods.pictures.light import Sky, random_sky
from caricli.methods.pictures.media import MEDIA
from caricli.methods.pictures.piece import Piece
from caricli.methods.pictures.pose import random_pose
from caricli.methods.pictures.settings import PoseSettings, SceneSettings
from caricli.methods.pictures.sitter import Sitter
from caricli.render.pixels.levels import to_bytes
from caricli.render.pixels.srgb import to_srgb
from caricli.render.sky import DIRECTIONS
from caricli.structures.parsing import Region


@dataclass(frozen=True, eq=False)
class Shown:
    """One face in a picture.

    sitter: its number among those who sat. points: (L, 2) pixels. visible: (L,) bool. rotation: (3, 3). scale: pixels a
    metre. translation: (2,) pixels, where the middle of the head is. perspective: see ``Pose``. light: (9, 3) spherical
    harmonics in the axes of the camera.
    """

    sitter: int
    points: np.ndarray
    visible: np.ndarray
    rotation: np.ndarray
    scale: float
    translation: np.ndarray
    perspective: float
    light: np.ndarray


@dataclass(frozen=True, eq=False)
class Composition:
    """A picture with all that is known of it.

    image: (S, S, 3) uint8. region: (S, S) uint8 Region. faces: those that it shows, the largest first. medium: a key of
    MEDIA.
    """

    image: np.ndarray
    region: np.ndarray
    faces: list[Shown]
    medium: str


class Easel:
    """Where pictures are composed."""

    def __init__(self, size: int, scene: SceneSettings | None = None, poses: PoseSettings | None = None) -> None:
        """size: pixels, width and height of a picture."""
        self.size = size
        self.scene = scene or SceneSettings()
        self.poses = poses or PoseSettings()
        self.drawn = round(self.scene.drawn * size)

    def compose(self, sitters: Sequence[Sitter], first: int, generator: np.random.Generator) -> Composition:
        """Draw one picture. sitters: who may be in it. first: the number of the one who is where there is one alone."""
        sky = random_sky(generator)
        image = np.array(random_background(self.drawn, generator))
        region = np.zeros((self.drawn, self.drawn), np.uint8)
        # Of every pixel the number, from 0, of the last drawing that covers it.
        latest = np.zeros(region.shape, int)
        people = self._people(sitters, first, sky, generator)
        for order, (_, drawing, _) in enumerate(people):
            shown = drawing.region > 0
            image[shown] = drawing.colours[shown]
            region[shown] = drawing.region[shown]
            latest[shown] = order
        faces = [(order, number, drawing) for order, (number, drawing, away) in enumerate(people) if not away]
        if faces and generator.random() < self.scene.held:
            _, number, drawing = faces[-1]
            hold_before(image, region, drawing.points, _skin_tone(sitters[number].pieces) * sky.above, generator)
            latest[region == Region.OTHER] = len(people)
        medium = str(generator.choice(list(MEDIA), p=[share for _, share in MEDIA.values()]))
        finished, labels = self._finish(image, region, medium, generator)
        shown_faces = [self._shown(number, drawing, latest <= order, sky) for order, number, drawing in reversed(faces)]
        return Composition(finished, labels, shown_faces, medium)

    def _finish(
        self, image: np.ndarray, region: np.ndarray, medium: str, generator: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """The picture (S, S, 3) uint8 and its Regions in the size that was asked for."""
        sides = (self.size, self.size)
        bright = to_srgb(_exposed(image, region, generator)).astype(np.float32)
        exposed = cv2.resize(bright, sides, interpolation=cv2.INTER_AREA)
        labels = cv2.resize(region, sides, interpolation=cv2.INTER_NEAREST_EXACT)
        drawn = MEDIA[medium][0](exposed, labels, generator)
        return to_bytes(drawn), labels

    def _people(
        self, sitters: Sequence[Sitter], first: int, sky: Sky, generator: np.random.Generator
    ) -> list[tuple[int, Drawing, bool]]:
        """Who is drawn, the smallest first, and who is seen from behind."""
        scene = self.scene
        kind = generator.random()
        strands = random_strands(generator)
        away = kind < scene.none
        chosen = [first]
        poses = self.poses
        if away:
            chosen = chosen if generator.random() < scene.away else []
            poses = replace(poses, around=180, farthest=poses.behind)
        elif kind < scene.none + scene.several:
            count = min(int(generator.integers(2, scene.most + 1)), len(sitters))
            chosen = generator.choice(len(sitters), count, replace=False).tolist()
            poses = replace(poses, aside=poses.apart)
        drawings = []
        for number in chosen:
            filled = self._filled(len(chosen), generator)
            pose = random_pose(sitters[number].skin, self.drawn, filled, generator, poses)
            drawing = draw_sitter(sitters[number], pose, self.drawn, sky, strands, generator)
            drawings.append((number, drawing, away))
        return sorted(drawings, key=lambda each: each[1].pose.scale)

    def _filled(self, count: int, generator: np.random.Generator) -> float:
        """Share of the picture's side that a face fills, one of so many."""
        poses = self.poses
        usual = generator.uniform(*poses.filled)
        if count > 1:
            return usual * generator.uniform(0.3, 0.7)
        kind = generator.random()
        if kind < poses.small:
            return float(np.exp(generator.uniform(*np.log(poses.small_filled))))
        return generator.uniform(*poses.close_filled) if kind < poses.small + poses.close else usual

    def _shown(self, number: int, drawing: Drawing, clear: np.ndarray, sky: Sky) -> Shown:
        """The face in the pixels of the finished picture. clear: (R, R) bool, where nothing is before its drawing."""
        at = np.clip(np.round(drawing.points).astype(int), 0, self.drawn - 1)
        scale = self.size / self.drawn
        pose = drawing.pose
        return Shown(
            number,
            (drawing.points + 0.5) * scale - 0.5,
            drawing.visible & clear[at[:, 1], at[:, 0]],
            pose.rotation,
            pose.scale * scale,
            (pose.translation + 0.5) * scale - 0.5,
            pose.perspective,
            sky.harmonics(DIRECTIONS),
        )


def _skin_tone(pieces: Piece) -> np.ndarray:
    """(3,) linear light, unlit: the usual colour of what is bare skin, or of all where nothing is."""
    skin = pieces.region == Region.SKIN
    return np.median(pieces.colours[skin if skin.any() else slice(None)], axis=0)


def _exposed(image: np.ndarray, region: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """The picture as bright as pictures are, more or less."""
    lit = image[(region == Region.SKIN) | (region == Region.NOSE)]
    bright = np.percentile(lit.max(1), 80) if len(lit) > 50 else 0.6
    target = generator.uniform(0.35, 0.95) if generator.random() < 0.8 else generator.uniform(0.08, 1.3)
    return image * np.clip(target / max(bright, 0.02), 0.3, 6.0)
