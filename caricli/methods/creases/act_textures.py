"""Textures of a person with many expressions, as ``texture`` takes them out of pictures."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.data.build_settings import EXPONENTS
from caricli.data.expressions import named_expressions
from caricli.data.regular_face import Person, regular_face
from caricli.data.texture_set import ActedTextures
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.methods.creases.actor import Stage
from caricli.methods.creases.random_acts import random_acts
from caricli.methods.dynamic.chart_pictures import ChartGrid, picture_to_chart, texture_to_chart
from caricli.methods.dynamic.show_mouth import show_mouth
from caricli.methods.pictures.draw_sitter import Drawing, draw_sitter, random_strands
from caricli.methods.pictures.light import Sky, random_sky
from caricli.methods.pictures.pose import Pose, random_pose
from caricli.methods.pictures.settings import PoseSettings
from caricli.methods.pictures.sitter import Sitter
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.settings import TextureSettings
from caricli.methods.texture.texels import Texels
from caricli.methods.texture.texture_face import FaceTexture, texture_face
from caricli.render.pixels.levels import to_bytes
from caricli.render.pixels.srgb import to_srgb
from caricli.render.pixels.widen_mask import widen_mask
from caricli.seeds import TextureSeed
from caricli.structures import Camera, Face
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.landmarks import COUNT
from caricli.structures.parsing import Region
from caricli.template.annotation import DELICATE
from caricli.template.chart import face_chart
from caricli.template.head import load_head
from caricli.template.template import Template

_UNPAINTED = (Region.EYES, Region.MOUTH, Region.TEETH, Region.HAIR, Region.HAT, Region.GLASSES)
"""What a texture of the skin is not taken from."""


@dataclass(frozen=True)
class ActSettings:
    """How people are drawn whose textures are taken.

    side: pixels of a picture. filled: of it, by the face, least and most. unwrapped: texels, side of the texture of the
    whole head that the chart is cut from. bright: linear light of the skin, least and most. youngest: age on the head's
    scale with which skin is young; own: share of the skin's age that only chance decides; spread: factor of its
    difference from the mean, so that many are quite young or quite old. folds: factors of the depth of folds in faces
    without exaggeration and in the most exaggerated, whose artists exaggerate these, too. seen: from 0 to 1, from
    where on a texel is said to be seen. edge: pixels around hair, eyes and open lips that are mixed with these. rim:
    texels beside the opening of the mouth that are its wall as much as lips.
    texture: TextureSettings; a picture so much finer than the chart needs little sharpening. pose: PoseSettings.
    """

    side: int = 320
    filled: tuple[float, float] = (0.56, 0.64)
    unwrapped: int = 320
    bright: tuple[float, float] = (0.3, 0.9)
    youngest: float = 0.6
    own: float = 0.5
    spread: float = 1.6
    folds: tuple[float, float] = (1.4, 2.4)
    seen: float = 0.5
    edge: int = 1
    rim: int = 1
    texture: TextureSettings = TextureSettings(rounds=2)
    pose: PoseSettings = PoseSettings(
        yaw=12, pitch=6, roll=5, farthest=30, turned=0.1, rolled=0.0, perspective=0.06, aside=0.03
    )


@dataclass(frozen=True, eq=False)
class Role:
    """One person to show expressions. number: of the unit of work. identity: in the dataset. person: Person. level:
    of exaggeration, from 1. exponent: of the curvature. split: of the dataset. count: expressions."""

    number: int
    identity: int
    person: Person
    level: int
    exponent: float
    split: str
    count: int


@dataclass(frozen=True, eq=False)
class Studio:
    """Where a person is before the camera. pose: Pose. sky: Sky. strands: see ``random_strands``. gain: of the light.
    camera: Camera that comes nearest to the pose. seed: of what else is random in a picture."""

    pose: Pose
    sky: Sky
    strands: np.ndarray
    gain: float
    camera: Camera
    seed: int


class TextureSource:
    """Draws people with expressions and takes their textures; prepared once in every process."""

    def __init__(self, template: Template, size: int, seed: int, settings: ActSettings | None = None) -> None:
        """template: Template of the open head. size: texels, of the chart. seed: of everything random."""
        self.template = template
        self.settings = settings or ActSettings()
        self.seed = seed
        self.stage = Stage(template)
        self.head = load_head()
        self.named = named_expressions(self.head.action_names)
        self.grid = ChartGrid(face_chart(template), size)
        self.hold = template.mask(*DELICATE).astype(float)
        self.texels = Texels(template, self.settings.unwrapped)

    def act(self, role: Role) -> ActedTextures:
        """Take the textures of one person."""
        generator = np.random.default_rng([self.seed, TextureSeed.PERSON, role.number])
        settings = self.settings
        acts = random_acts(self.named, role.count, generator)
        shapes = np.stack([self._shape(role, act) for act in acts])
        old = (role.person.identity.age - settings.youngest) / (1 - settings.youngest)
        mixed = (1 - settings.own) * old + settings.own * generator.random()
        age = float(np.clip(0.5 + settings.spread * (mixed - 0.5), 0, 1))
        deep = float(np.interp(role.level, (1, len(EXPONENTS)), settings.folds))
        actor = self.stage.engage(shapes[0], age, deep, generator)
        sitters = self.stage.perform(actor, shapes[0], shapes, acts)
        studio = self._studio(sitters[0], generator)
        textures = list(self._textures(sitters, studio))
        return ActedTextures(
            pictures=np.stack([picture for picture, _ in textures]),
            seen=np.stack([seen for _, seen in textures]),
            weights=np.array([[act.get(name, 0.0) for name in ARKIT_NAMES] for act in acts], np.float32),
            vertices=shapes.astype(np.float32),
            neutral=shapes[0].astype(np.float32),
            person=role.identity,
            level=role.level,
            split=role.split,
            age=age,
        )

    def _shape(self, role: Role, act: Mapping[str, float]) -> np.ndarray:
        vertices = regular_face(role.person, act, self.head)
        if role.exponent:
            vertices = exaggerate_curvature(vertices, self.template.faces, [role.exponent], self.hold)[0]
        return self.template.cavities.tuck(vertices)

    def _studio(self, sitter: Sitter, generator: np.random.Generator) -> Studio:
        """A random place, as bright as the neutral face asks for."""
        settings = self.settings
        filled = float(generator.uniform(*settings.filled))
        pose = random_pose(sitter.skin, settings.side, filled, generator, settings.pose)
        points = sitter.skin.vertices[self.template.annotation.landmarks[:COUNT]]
        bright = float(generator.uniform(*settings.bright))
        seed = int(generator.integers(2**32))
        studio = Studio(
            pose, random_sky(generator), random_strands(generator), 1.0, _nearest_camera(pose, points), seed
        )
        drawing = self._drawing(sitter, studio)
        skin = drawing.colours[np.isin(drawing.region, (Region.SKIN, Region.NOSE))].max(1)
        return replace(studio, gain=bright / max(float(np.percentile(skin, 80)), 1e-3))

    def _drawing(self, sitter: Sitter, studio: Studio) -> Drawing:
        generator = np.random.default_rng(studio.seed)
        return draw_sitter(sitter, studio.pose, self.settings.side, studio.sky, studio.strands, generator)

    def _textures(self, sitters: Sequence[Sitter], studio: Studio) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Pictures in the chart and what of them was seen; light is found on the neutral face, the first one."""
        like: FaceTexture | None = None
        for sitter in sitters:
            drawing = self._drawing(sitter, studio)
            image = to_bytes(to_srgb(studio.gain * drawing.colours))
            face = Face(sitter.skin, camera=studio.camera, landmarks=drawing.points)
            sight = self._sight(studio.camera, image, drawing.region)
            texture = texture_face(sitter.skin, sight, self.texels, self.settings.texture, like=like)
            like = like or texture
            yield self._charted(texture, face, image), self._seen(texture, face, drawing.region)

    def _sight(self, camera: Camera, image: np.ndarray, regions: np.ndarray) -> Sight:
        """What the camera saw of the head; regions (H, W) are true, so that openings need not be looked for."""
        whole = regions != Region.BACKGROUND
        others = widen_mask(np.isin(regions, _UNPAINTED), self.settings.edge)
        return Sight(camera, image, whole & ~others, whole)

    def _charted(self, texture: FaceTexture, face: Face, image: np.ndarray) -> np.ndarray:
        """(S, S, 3) uint8, the picture of the chart."""
        return show_mouth(texture_to_chart(texture.image, face.mesh, self.grid), image, face, self.grid)

    def _seen(self, texture: FaceTexture, face: Face, regions: np.ndarray) -> np.ndarray:
        """(S, S) bool, where the picture showed skin, and what is between the lips.

        Strands of a beard are no skin: they lie otherwise in every expression. regions: (H, W) of the picture.
        """
        grid = self.grid
        beard = picture_to_chart(np.dstack(3 * [255 * (regions == Region.BEARD).astype(np.uint8)]), face, grid)
        lips = ~widen_mask(grid.mouth, self.settings.rim)
        skin = texture_to_chart(texture.seen, face.mesh, grid) >= self.settings.seen
        return grid.covered & skin & (beard[..., 0] == 0) & lips | grid.mouth


def _nearest_camera(pose: Pose, points: np.ndarray) -> Camera:
    """The scaled orthographic Camera that sees points (N, 3) as nearly as can be where a pose has them."""
    flat = points @ pose.rotation[:2].T
    placed = pose.place(points)[:, :2]
    away = flat - flat.mean(0)
    scale = float((away * placed).sum() / (away**2).sum())
    return Camera(scale, pose.rotation, placed.mean(0) - scale * flat.mean(0))
