"""A picture that a head was fitted to: what it shows of the head, and what is before and behind it."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.methods.detect.cut_openings import cut_openings
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.dress_texture import inside_chart
from caricli.methods.redraw.settings import RedrawSettings
from caricli.methods.redraw.spread_colours import spread_colours
from caricli.methods.redraw.view import View, Window
from caricli.methods.texture.edited_since_fit import NOTICED, edited_since_fit
from caricli.methods.texture.estimate_light import Light
from caricli.methods.texture.head_picture import HeadPicture
from caricli.methods.texture.light_on_head import light_on_head
from caricli.methods.texture.mouth_wall import mouth_wall
from caricli.methods.texture.picture_view import PictureView, Sight, SurfacePoints, likeness
from caricli.methods.texture.settings import TextureSettings
from caricli.render.pixels.sample_texture import sample_pixels, uv_pixels
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Depiction, Face, Material, Rig
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, LIPS
from caricli.structures.parsing import HEAD_REGIONS, Region
from caricli.template.chart import face_chart
from caricli.template.template import Template

if TYPE_CHECKING:
    from caricli.methods.redraw.tooth_rows import ToothRows

PAPER = 255
"""Of every colour of what a transparent picture is laid on."""

_DRAWN = (Material.SKIN, Material.EYE, Material.TEETH, Material.GUMS, Material.TONGUE)
_HELD = (Region.GLASSES, Region.HAT, Region.OTHER)
_SHOWN = (*HEAD_REGIONS, *_HELD, Region.HAIR)
_LAID = (Region.HAIR, Region.CLOTH)
_OPENINGS = (Region.EYES, Region.MOUTH, Region.TEETH)
_OPEN_MOUTH = 2e-3  # of the square of the head's height
_SHUT_EYE = 3e-4
_RIM = 0.02  # of the head's height, by which a label map may miss what is drawn of an eye
_AROUND_EYE = 1.5  # of the size of an eye with its lids
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_CHART = 128  # texels, of the chart in which distances from its border are taken
_LEAST = 0.6  # of the head, and of its pixels
_FAR = 1e6
_STRONGEST = 1.5  # weight of an expression
_MARGIN = 0.08  # of the head's height, around what moves: there is what goes with it


@dataclass(frozen=True, eq=False)
class Original:
    """A picture with a head in it.

    rig: Rig of the head, with its Depiction. template: Template of its skin, whose vertices come first. picture:
    (H, W, 3) uint8. regions: (H, W) values of Region, or None where nothing tells them: all that the head covers is
    the head then. settings: RedrawSettings. layer: (H, W, 4) uint8, a picture that is transparent in places with how
    opaque it is, ``picture`` being it on white paper; or None.
    Raises InputError when the rig has no camera, or the head is outside of the picture.
    """

    rig: Rig
    template: Template
    picture: np.ndarray
    regions: np.ndarray | None = None
    settings: RedrawSettings = RedrawSettings()  # noqa: RUF009 (frozen)
    layer: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check that the head is in the picture."""
        height, width = self.picture.shape[:2]
        inside = (self.placed[:, :2] > 0).all(1) & (self.placed[:, :2] < [width, height]).all(1)
        pixels = self.window.means(self.view.covered.astype(np.float32)) > 0.5
        seen = None if self.regions is None else np.isin(self.window.cut(self.regions), _SHOWN)
        if inside.mean() < _LEAST or (seen is not None and (seen & pixels).sum() < _LEAST * pixels.sum()):
            raise InputError("expected the picture that the face was fitted to, in its size, found no head where it is")

    @cached_property
    def depiction(self) -> Depiction:
        """Of the rig."""
        return self.rig.require_depiction()

    @cached_property
    def kept(self) -> np.ndarray:
        """(F,) bool: the triangles that are drawn; hair, lashes and what is below the neck are in the picture."""
        return np.isin(self.rig.triangle_materials, _DRAWN)

    @cached_property
    def faces(self) -> np.ndarray:
        """(G, 3) the triangles that are drawn."""
        return self.rig.faces[self.kept]

    @cached_property
    def size(self) -> float:
        """Pixels, height of the head in the picture."""
        return self.depiction.camera.scale * self.template.with_vertices(self.skin).height

    @property
    def skin(self) -> np.ndarray:
        """(N, 3) the vertices of the skin, metres."""
        return self.depiction.vertices[: len(self.template.vertices)].astype(float)

    @cached_property
    def placed(self) -> np.ndarray:
        """(W, 3) pixels and depth of the vertices."""
        return self.depiction.camera.place(self.depiction.vertices.astype(float))

    @cached_property
    def window(self) -> Window:
        """Where expressions reach."""
        height, width = self.picture.shape[:2]
        nearest, farthest = self._reach
        drawn = np.unique(self.faces)
        moving = drawn[np.linalg.norm(farthest - nearest, axis=1)[drawn] > self.settings.still / 2]
        moving = moving if len(moving) else drawn
        margin = _MARGIN * self.size
        left, top = np.clip(np.floor(nearest[moving].min(0) - margin), 0, [width - 1, height - 1]).astype(int)
        right, bottom = np.clip(np.ceil(farthest[moving].max(0) + margin), 1, [width, height]).astype(int)
        across = max(right - left, 1)
        down = max(bottom - top, 1)
        fine = int(np.clip(self.settings.largest // max(across, down), 1, self.settings.fine))
        return Window(int(left), int(top), int(across), int(down), fine)

    @property
    def _reach(self) -> tuple[np.ndarray, np.ndarray]:
        """(W, 2) pixels, the least and the largest x and y of vertices in the picture or in any expression."""
        camera = self.depiction.camera
        neutral = camera.project(self.rig.neutral.astype(float))
        moves = camera.scale * self.rig.deltas @ camera.rotation[:2].T
        nearest = neutral + _STRONGEST * moves.min(0, initial=0.0)
        farthest = neutral + _STRONGEST * moves.max(0, initial=0.0)
        return np.minimum(nearest, self.placed[:, :2]), np.maximum(farthest, self.placed[:, :2])

    @cached_property
    def view(self) -> View:
        """The head as the picture shows it."""
        return self.see(self.placed)

    def see(self, placed: np.ndarray) -> View:
        """The head with its vertices at other pixels and depths (W, 3)."""
        return View(placed, self.faces, self.window, self.settings.jump * self.size, self.wall)

    @cached_property
    def depth(self) -> np.ndarray:
        """(H, W) float32 pixels, depth of the head at the samples, far behind it beside it."""
        return np.where(self.view.covered, self.view.depth, np.float32(_FAR))

    @cached_property
    def nearest(self) -> np.ndarray:
        """(H, W) float32 depth of the head at the samples; along edges that of what is farther off."""
        return cv2.dilate(self.depth, np.ones((3, 3), np.uint8))

    def disc(self, share: float) -> np.ndarray:
        """(N, N) uint8, a disc to dilate samples with. share: of the head's height, its radius."""
        across = 2 * int(np.ceil(share * self.size * self.window.fine)) + 1
        return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (across, across))

    def of_regions(self, *regions: Region) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show some regions, with soft borders."""
        if self.regions is None:
            return np.zeros(self.view.face.shape, np.float32)
        shown = self.window.sampled(np.isin(self.regions, regions).astype(np.float32))
        return blurred(shown, self.settings.soft * self.window.fine)

    @cached_property
    def head(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show the head, without hair and what is before it."""
        if self.regions is None:
            return self.view.covered.astype(np.float32)
        return self.of_regions(*HEAD_REGIONS)

    @cached_property
    def openings(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show what is between lips or lids."""
        landmarks = self.depiction.landmarks
        if self.regions is None or landmarks is None:
            return np.zeros(self.view.face.shape, np.float32)
        openings = cut_openings(self.picture, self.regions, landmarks) | np.isin(self.regions, _OPENINGS)
        # Their borders are mixtures.
        shown = self.window.sampled(cv2.dilate(openings.astype(np.uint8), _CROSS).astype(np.float32))
        return blurred(shown, self.settings.soft * self.window.fine)

    @cached_property
    def rims(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples are so near to openings that these may be there, and no brows."""
        return cv2.dilate(self.openings, self.disc(_RIM)) * (1 - self.of_regions(Region.BROWS))

    @cached_property
    def held(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: glasses, hats and hands before the head."""
        return self.of_regions(*_HELD) * self.view.covered

    @cached_property
    def laid(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: hair and clothes before the head; what is nearer than it covers them, too."""
        return self.of_regions(*_LAID) * self.view.covered

    @cached_property
    def hidden(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show, or may show, what is before the head."""
        # Borders are mixtures.
        around = np.ones((2 * self.window.fine + 1, 2 * self.window.fine + 1), np.uint8)
        return cv2.dilate(np.maximum(self.held, self.laid), around)

    @cached_property
    def beyond(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show what is behind the head."""
        if self.regions is None:
            return 1 - self.view.covered.astype(np.float32)
        return self.of_regions(Region.BACKGROUND)

    @cached_property
    def beside(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show, or may show, what is behind the head, or its outline.

        A label map may miss by more what is drawn: near its border, colours count that are not those farther inside.
        """
        near = cv2.dilate(self.beyond, self.disc(self.settings.stain))
        old = self.window.sampled(self.picture).astype(np.float32)
        usual = spread_colours(old, self.head * (1 - near) * (1 - self.hidden))
        like = likeness(old.reshape(-1, 3), usual.reshape(-1, 3), TextureSettings.other).reshape(near.shape)
        other = near * (1 - like.astype(np.float32))
        return np.maximum(cv2.dilate(self.beyond, self.disc(self.settings.line)), other)

    @cached_property
    def apart(self) -> np.ndarray:
        """(H, W) float32 from 0 to 1: how far samples show what is behind the head and goes on beside it, be they on
        the mesh or not; what a label map takes for background amid a face is not meant.
        """
        shown = (self.beyond > 0.5).astype(np.uint8)
        labels = cv2.connectedComponents(shown, connectivity=4)[1]
        beside = np.unique(labels[~self.view.covered])
        return np.where(np.isin(labels, beside), self.beyond, 0).astype(np.float32)

    @cached_property
    def wall(self) -> np.ndarray:
        """(W,) from 0 to 1: how far vertices are in the mouth, all of teeth, gums and tongue."""
        wall = np.zeros(len(self.rig.neutral))
        inside = (Material.TEETH, Material.GUMS, Material.TONGUE)
        wall[np.unique(self.rig.faces[np.isin(self.rig.triangle_materials, inside)])] = 1
        wall[: len(self.template.vertices)] = mouth_wall(self.template)
        return wall

    @cached_property
    def deep(self) -> np.ndarray:
        """(W,) share of the light that reaches vertices where nothing of it does, in the depth of a mouth."""
        deep = np.full(len(self.rig.neutral), self.settings.deep)
        deep[np.unique(self.rig.faces[self.rig.triangle_materials == Material.TEETH])] = self.settings.teeth
        return deep

    @cached_property
    def rows(self) -> "ToothRows | None":
        """What goes with upper and what with lower teeth, or None where the head has no teeth."""
        from caricli.methods.redraw.tooth_rows import ToothRows

        return ToothRows.of(self)

    @cached_property
    def eyes(self) -> dict[str, np.ndarray]:
        """Of the left and the right eye, by the names of their lids, (W,) 1 at their vertices."""
        eyes = np.zeros(len(self.rig.neutral))
        eyes[np.unique(self.rig.faces[self.rig.triangle_materials == Material.EYE])] = 1
        left = self.rig.neutral[:, 0] > 0
        return {"eyes_left": eyes * left, "eyes_right": eyes * ~left}

    @cached_property
    def charted(self) -> np.ndarray:
        """(W, 3) where vertices are in the chart of the face, origin at the bottom left, and from 0 at its border and
        beyond it to 1, how far changes of its paint reach them.
        """
        grid = ChartGrid(face_chart(self.template), _CHART)
        chart = grid.chart
        at = uv_pixels(chart.uvs, (_CHART, _CHART))
        charted = np.zeros((len(self.rig.neutral), 3))
        charted[chart.vertices] = np.column_stack([chart.uvs, sample_pixels(inside_chart(grid), at[:, 0], at[:, 1])])
        return charted

    @cached_property
    def lids(self) -> dict[str, np.ndarray]:
        """Of the left and the right eye (W,) bool, by their names: vertices of lids and around them, where eyes that
        are drawn larger than the head's may lie; none where the annotation does not name them.
        """
        skin = self.rig.neutral[: len(self.template.vertices)]
        lids = {name: np.zeros(len(self.rig.neutral), bool) for name in self.eyes}
        for name, near in lids.items():
            own = skin[self.template.mask(name)]
            if len(own):
                away = np.linalg.norm(skin - own.mean(0), axis=1)
                near[: len(skin)] = away < _AROUND_EYE * np.linalg.norm(own - own.mean(0), axis=1).max()
        return lids

    @cached_property
    def mouth(self) -> np.ndarray:
        """(H, W) bool: samples of the head that show what is in the mouth, by the label map where there is one."""
        landmarks = self.depiction.landmarks
        if self.regions is None or landmarks is None:
            return self.view.inside
        away = [
            np.linalg.norm(self.window.places - landmarks[list(part)].mean(0).astype(np.float32), axis=2)
            for part in (LIPS, EYE_LEFT, EYE_RIGHT)
        ]
        # Far from the head, a label map may see mouths in anything.
        return self.view.covered & (self.openings > 0.5) & (away[0] < np.minimum(*away[1:]))

    @property
    def is_open(self) -> bool:
        """Whether the picture shows the mouth open."""
        return bool(self.mouth.sum() > _OPEN_MOUTH * (self.size * self.window.fine) ** 2)

    @cached_property
    def edited(self) -> float:
        """How far the face is from where it was fitted in the picture, see ``edited_since_fit``; 0 where none knows."""
        landmarks = self.depiction.landmarks
        if landmarks is None:
            return 0.0
        head = self.template.with_vertices(self.skin)
        return edited_since_fit(Face(head, self.depiction.camera, landmarks), self.template)

    def unknown(self) -> list[str]:
        """What the picture does not tell, for messages."""
        area = (self.size * self.window.fine) ** 2
        notes = []
        if self.edited > NOTICED:
            away = f"landmarks are up to {100 * self.edited:.1f} % of their diagonal away"
            notes.append(f"the face was edited after it was fitted: {away}, and what moves is taken from as far aside")
        if self.rig.pictures.skin is None:
            notes.append(
                "the face has no texture (caricli texture): what the picture hides takes the colours beside it"
            )
        if self.is_open or self.view.inside.sum() > _OPEN_MOUTH * area:
            notes.append("the picture shows the mouth open: how lips look that close, it does not tell")
        if any((self.view.carried(eye[:, None]) > 0.5).sum() < _SHUT_EYE * area for eye in self.eyes.values()):
            notes.append("the picture shows an eye shut: how it looks when it opens is made up")
        return notes

    @cached_property
    def light(self) -> Light | None:
        """The light in the picture, or None: of a head without UVs, which has no texture, and where skin that is seen
        is too little, or tells too little of light (see ``estimate_light``).
        """
        head = self.template.with_vertices(self.skin)
        if head.uvs is None:
            return None
        camera = self.depiction.camera
        mask = self.window.means(self.head) > 0.5
        whole = np.zeros(self.picture.shape[:2], bool)
        self.window.cut(whole)[:] = mask
        settings = TextureSettings()
        near = HeadPicture(Face(head, camera), self.picture, whole).near_head(settings.buffer)
        assert near.mask is not None
        view = PictureView(head, Sight(near.face.require_camera(), near.image, near.mask), settings)
        normals = smooth_normals(head.vertices, head.faces)
        seen = view.look(SurfacePoints(head.vertices, normals, np.zeros(len(normals)), mouth_wall(head)))
        return light_on_head(head, seen, camera)


def blurred(samples: np.ndarray, spread: float) -> np.ndarray:
    """Means of samples (H, W, ...) with Gaussian weights. spread: their standard deviation, in samples."""
    return cv2.GaussianBlur(samples, (0, 0), spread)
