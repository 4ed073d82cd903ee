"""A rig before one camera, for pictures of its frames."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from caricli.errors import InputError
from caricli.geometry.used_points import used_points
from caricli.render.backdrop import on_backdrop
from caricli.render.coat import rig_coat
from caricli.render.face_look import combed_hair, plain_colours
from caricli.render.in_parallel import in_parallel
from caricli.render.lights import KEY
from caricli.render.shade import Look, shade
from caricli.render.sky import DIRECTIONS, key_directions, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import TO_PICTURE, VIEWS, turn_about_y
from caricli.render.visibility.seen_vertices import seen_vertices
from caricli.structures import Material, Rig

_FILL = 0.82  # of the picture: jaws drop and heads turn
_SUPERSAMPLE = 2  # its square is the number of rays through a border's pixel; frames are small, or on the move
_HIDDEN = 0.7  # of the sky of a free vertex; what sees less at rest, as the mouth does, may come out
_BEHIND_LIPS = (Material.TEETH, Material.GUMS, Material.TONGUE)  # these come out of a shadow that moves
_STILL = 1e-3  # of the rig's height: a vertex that moves less sees of the sky what it sees at rest


class RigStage:
    """What the frames of a rig share: the camera, which depends on the neutral face alone, so that they follow each
    other calmly, the pictures, and what its vertices see of the sky.

    Without a picture a material is as plain as its finish. What is hidden in the neutral face, and moves or comes into
    sight, looks around anew, so that an open mouth shows its wall.
    """

    def __init__(self, rig: Rig, view: str = "front", size: int = 512) -> None:
        """rig: Rig. view: a key of VIEWS. size: pixels, width and height. Raises InputError for an unknown view."""
        if view not in VIEWS:
            raise InputError(f"no view is called {view!r}: expected one of {', '.join(VIEWS)}")
        self.rig = rig
        self.size = size
        self.rotation = TO_PICTURE @ turn_about_y(VIEWS[view])
        neutral = used_points(rig.neutral, rig.faces) @ self.rotation.T
        low = neutral.min(0)
        high = neutral.max(0)
        self.scale = _FILL * size / ((high - low)[:2].max() or 1)
        self.least = _STILL * np.ptp(neutral[:, 1])
        self.shift = np.array([(size - 1) / 2, (size - 1) / 2, 0]) - self.scale * (low + high) / 2
        hair = combed_hair(rig.mesh, rig.triangle_materials)
        normals = smooth_normals(rig.neutral, rig.faces)
        normals = normals if hair is None else hair.normals(normals)
        placed = self._placed(rig.neutral)
        ways = np.concatenate([DIRECTIONS, key_directions(KEY) @ self.rotation])
        sky, key = np.split(sky_visibility(rig.neutral, rig.faces, normals, None, ways), [len(DIRECTIONS)], axis=1)
        coat = rig_coat(rig)
        self.look = Look(
            vertex_colours=plain_colours(rig.mesh, rig.triangle_materials, rig.pictures),
            coat=None if coat is None else coat.shrunk(placed, rig.faces),
            hair=hair,
            visibility=sky,
            key=key,
            rotation=self.rotation,
            supersample=_SUPERSAMPLE,
        )
        # Half of the directions are behind a surface.
        self.hidden = sky.mean(1) < _HIDDEN / 2
        self.shown = seen_vertices(placed, rig.faces, size, size)
        self.shown[rig.faces[np.isin(rig.triangle_materials, _BEHIND_LIPS)]] = False

    def picture(self, vertices: np.ndarray, skin: np.ndarray | None = None) -> np.ndarray:
        """Draw one frame.

        vertices: (V, 3), metres. skin: (H, W, 3) uint8, the picture of the skin in it, or None for the rig's.
        Returns (size, size, 3) uint8. Raises InputError when they are not the rig's.
        """
        vertices = np.asarray(vertices, float)
        if vertices.shape != self.rig.neutral.shape:
            expected = self.rig.neutral.shape
            raise InputError(f"a frame of this rig needs vertices of shape {expected}, found {vertices.shape}")
        moved = np.linalg.norm(vertices - self.rig.neutral, axis=1) > self.least
        look = replace(self.look, hidden=self.hidden & (moved | ~self.shown))
        if skin is not None and look.coat is not None:
            worn = replace(look.coat.pictures, skin=skin)
            look = replace(look, coat=replace(look.coat, pictures=worn))
        return on_backdrop(shade(self._placed(vertices), self.rig.faces, self.size, self.size, look))

    def pictures(
        self, frames: Iterable[np.ndarray], paint: Callable[[int], np.ndarray] | None = None
    ) -> Iterator[np.ndarray]:
        """Draw many frames, in their order, several at a time. paint: makes the picture of the skin in a frame, by its
        number, or None for the rig's.
        """

        def draw(numbered: tuple[int, np.ndarray]) -> np.ndarray:
            number, frame = numbered
            return self.picture(frame, None if paint is None else paint(number))

        # Whoever makes frames may overwrite the last one.
        return in_parallel(draw, enumerate(np.array(frame) for frame in frames))

    def _placed(self, vertices: np.ndarray) -> np.ndarray:
        return self.scale * vertices @ self.rotation.T + self.shift
