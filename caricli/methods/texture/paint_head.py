"""A head with the colours of its picture: skin, eyes, and how near they come."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.geometry.uvs_beyond import uvs_beyond
from caricli.methods.detect.cut_openings import cut_openings
from caricli.methods.hair.bare_skin import bare_skin
from caricli.methods.hair.dress_hair import DressedHair, dress_hair, hair_picture
from caricli.methods.hair.shade_scalp import Scalp
from caricli.methods.parts.close_neck import neck_picture
from caricli.methods.parts.face_parts import chosen_attachment, face_parts
from caricli.methods.rig.add_eyeballs import add_eyeballs, fit_eyeballs
from caricli.methods.rig.add_parts import add_parts, choose_parts
from caricli.methods.texture.estimate_light import Light
from caricli.methods.texture.eye_picture import eye_picture
from caricli.methods.texture.head_picture import HeadPicture
from caricli.methods.texture.lid_lines import LidLine, draw_lid_lines, seen_lid_line
from caricli.methods.texture.lips_behind_nose import lips_behind_nose
from caricli.methods.texture.mask_head import mask_head, mesh_pixels
from caricli.methods.texture.mouth_wall import wall_pixels
from caricli.methods.texture.parsed_head import ParsedHead, parsed_head
from caricli.methods.texture.photometric_error import photometric_error
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.project_picture import project_picture
from caricli.methods.texture.seen_eyes import seen_eyes
from caricli.methods.texture.settings import PaintSettings
from caricli.methods.texture.shown_teeth import shown_teeth
from caricli.methods.texture.texels import Texels
from caricli.methods.texture.texture_face import FaceTexture, texture_face
from caricli.render.in_parallel import do_in_parallel
from caricli.render.pixels.diffuse_background import diffuse_background
from caricli.render.sky import mesh_sky
from caricli.structures import Face, Pictures, Rig
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class Painted:
    """A textured head and how it was come by.

    face: Face that was painted, with its skull under its hair, and teeth as far as the picture shows them.
    head: Template in the shape of the face, with the UVs of its texture.
    rig: Rig of the whole head, without expressions; the vertices of the face come first.
    error: photometric error of the skin but for the wall of the mouth, which teeth hide; of full scale.
    seen: share of the surface that the picture shows.
    filled: share of the picture that the head fills.
    light: Light that was taken out of the picture, or None where it was kept; the error is measured in it.
    hair: DressedHair on the head, or None.
    sky: (V, D) of the rig's mesh as `mesh_sky` gives it, where it was asked for, or None.
    """

    face: Face
    head: Template
    rig: Rig
    error: float
    seen: float
    filled: float
    light: Light | None = None
    hair: DressedHair | None = None
    sky: np.ndarray | None = None

    @property
    def pictures(self) -> Pictures:
        """What the head wears."""
        return self.rig.pictures

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        assert self.pictures.skin is not None
        light = {} if self.light is None else {"light": self.light.figures()}
        hair = {"hair": None if self.hair is None else self.hair.figures()}
        return {"size": len(self.pictures.skin), "photometric_error": self.error, "seen": self.seen} | light | hair

    def describe(self) -> str:
        """What is printed of it."""
        hair = "no hair" if self.hair is None else f"hair {100 * self.hair.overlap:.0f} % as in the picture"
        return f"{100 * self.seen:.0f} % of the surface seen, photometric error {100 * self.error:.2f} %, {hair}"


def paint_head(
    face: Face,
    template: Template,
    image: np.ndarray,
    mask: np.ndarray | None = None,
    settings: PaintSettings = PaintSettings(),  # noqa: B008 (frozen)
    regions: np.ndarray | None = None,
) -> Painted:
    """Paint a head with the picture that it was fitted to, its eyes in the colours that they have there.

    face: Face with camera and fitted landmarks. template: Template of its topology. image: (H, W, 3) uint8. mask:
    (H, W) bool, the head in it, or None to find it. settings: PaintSettings. regions: (H, W) values of Region, by which
    the head is found where there is no mask, and its hair, and glasses, hats and hands before it are kept off it; None
    to tell them by colours, which also do where the regions show no head there, or none of its skin.
    Returns Painted. Raises InputError when the template has no UVs and is to have a texture of its own, when the face
    has no camera or no landmarks, and when it is not where picture and mask show a head.
    """
    given = HeadPicture(face, image, mask, regions)
    picture = given if settings.project_uv else given.near_head(_most_pixels(settings))
    ground = _lay_groundwork(picture, template, settings)
    hair = ground.hair
    seen_face = replace(picture.face, hair=None) if hair is None else replace(hair.face, hair=hair.hair)
    seen_face = replace(seen_face, teeth=ground.teeth)
    head = _laid_out(template.with_vertices(seen_face.vertices), picture, settings)
    still = np.zeros((0, *head.vertices.shape), np.float32)
    bare = Rig((), head.with_vertices(head.vertices.astype(np.float32)), still)
    whole = add_eyeballs(
        bare, fit_eyeballs(head, head.annotation, still), np.random.default_rng(settings.seed), ground.eyes
    )
    whole = choose_parts(add_parts(whole, face_parts(seen_face, template, settings.head)), settings.head)
    # None of these waits for another.
    jobs: list[Callable[[], Any]] = [partial(_skin_texture, head, ground, settings)]
    if hair is not None:
        jobs += [partial(hair_picture, hair, picture.image, settings), partial(Scalp, head, hair.hair, settings.size)]
    if settings.sky:
        jobs.append(partial(mesh_sky, whole.mesh.vertices, whole.mesh.faces))
    skin_texture, *rest = do_in_parallel(*jobs)
    sky = rest.pop() if settings.sky else None
    texture = skin_texture.image
    hair_texture = None
    if hair is not None:
        hair_texture, scalp = rest
        texture = scalp.shaded(skin_texture, hair_texture, np.random.default_rng(settings.seed))
    bare = replace(bare, pictures=Pictures(texture))
    wall = wall_pixels(head, ground.sight.camera, picture.size)
    error = photometric_error(bare, seen_face, picture.image, ground.sight.mask & ~wall, skin_texture.light)
    neck = neck_picture(head.with_vertices(template.vertices), texture, skin_texture.image)
    pictures = Pictures(texture, whole.pictures.eyes, hair_texture, neck).with_toned_eyes()
    seen = float(skin_texture.seen[skin_texture.covered].mean())
    whole = replace(whole, pictures=pictures)
    filled = picture.share * float(ground.mask.mean())
    painted = replace(seen_face, camera=face.camera, landmarks=face.landmarks)
    return Painted(painted, head, whole, error, seen, filled, skin_texture.light, hair, sky)


def _most_pixels(settings: PaintSettings) -> int:
    """Pixels of the head, its longer side, beyond which a picture tells its texture nothing more."""
    limits = settings.texture
    return min(max(settings.size or limits.buffer, limits.smallest), limits.buffer)


@dataclass(frozen=True, eq=False)
class _Groundwork:
    """What is known before anything is painted.

    mask: (H, W) bool, the head in the picture. sight: Sight of its bare skin. hair: DressedHair, or None. texels:
    Texels, or None where the view has to tell their number first, or has a layout of its own. eyes: picture of an eye.
    lids: LidLine, or None. teeth: (2,) metres, see Face, or None.
    """

    mask: np.ndarray
    sight: Sight
    hair: DressedHair | None
    texels: Texels | None
    eyes: np.ndarray
    lids: LidLine | None
    teeth: np.ndarray | None


def _lay_groundwork(picture: HeadPicture, template: Template, settings: PaintSettings) -> _Groundwork:
    """Look at a picture; for the arguments see `paint_head`."""
    face = picture.face
    image = picture.image
    landmarks = face.require_landmarks()
    pixels = mesh_pixels(face, image)
    parsing = None if picture.mask is not None else picture.regions
    # Neither of these waits for the other.
    parsed, texels = do_in_parallel(
        lambda: None if parsing is None else parsed_head(parsing, pixels, image),
        partial(_find_texels, template, settings),
    )
    parts = _find_head(picture, pixels) if parsed is None else parsed
    regions = None if parsed is None else parsing
    looks: list[Callable[[], Any]] = [partial(dress_hair, face, template, image, settings, regions, pixels)]
    generator = np.random.default_rng(settings.seed)
    eyes_seen = landmarks if regions is None else seen_eyes(landmarks, regions)
    looks.append(partial(eye_picture, face, eyes_seen, template.annotation, image, generator))
    # Nothing here needs this, but what comes next, and one processor is free.
    looks.append(partial(chosen_attachment, template, settings.head))
    looks.append(partial(seen_lid_line, image, eyes_seen))
    camera = face.require_camera()
    teeth = None
    if regions is not None:
        head = template.with_vertices(face.vertices)
        teeth = shown_teeth(face, head, regions)
        looks.append(partial(cut_openings, image, regions, landmarks))
        looks.append(partial(lips_behind_nose, head, camera, regions))
    hair, eyes, _, lids, *no_skin = do_in_parallel(*looks)
    skin = _uncovered(parts, hair, image, regions is not None)
    beside = parts.whole & ~skin
    for opening in no_skin:
        skin = skin & ~opening
    if not (skin & pixels).any():
        if regions is None:
            raise InputError("expected skin where the face was fitted, found none there")
        # What is labelled hair or an opening all over tells nothing of the face.
        return _lay_groundwork(replace(picture, regions=None), template, settings)
    sight = Sight(camera, image, skin, parts.whole, beside)
    return _Groundwork(parts.whole, sight, hair, texels, eyes, lids, teeth)


def _uncovered(parts: ParsedHead, hair: DressedHair | None, image: np.ndarray, labelled: bool) -> np.ndarray:
    """(H, W) bool: what can be painted of a head in its hair, or without any. image: (H, W, 3) uint8.

    labelled: whether regions told the hair: then there may be nothing. Where colours did, nobody knows better, and what
    they take for hair all over is painted nevertheless.
    """
    if hair is None:
        return parts.paint
    bare = bare_skin(parts, hair, image)
    return bare if labelled or bare.any() else parts.paint


def _find_texels(template: Template, settings: PaintSettings) -> Texels | None:
    """The Texels of a template, or None, see `_Groundwork`."""
    if settings.size is None or settings.project_uv or template.uvs is None:
        return None
    # First, because UVs far beyond the texture cover none of its texels, either.
    _check_uvs(template.uvs)
    return Texels(template, settings.size)


def _laid_out(head: Template, picture: HeadPicture, settings: PaintSettings) -> Template:
    """The head with the UVs of its texture. Raises InputError where there are none, and none are made."""
    if settings.project_uv:
        return project_picture(head, picture.face.require_camera(), picture.image)
    if head.uvs is None:
        raise InputError("expected a model whose mesh has UVs, found none; --project-uv needs none")
    _check_uvs(head.uvs)
    return head


def _check_uvs(uvs: np.ndarray) -> None:
    """Raise InputError for UVs (T, 2) beyond the texture."""
    beyond = uvs_beyond(uvs)
    if beyond is not None:
        raise InputError(f"expected a mesh whose UVs are from 0 to 1, found them {beyond}")


def _skin_texture(head: Template, ground: _Groundwork, settings: PaintSettings) -> FaceTexture:
    """The texture of a head as its UVs are laid out."""
    sight = ground.sight
    if settings.project_uv:
        everywhere = np.ones(sight.mask.shape, bool)
        image = diffuse_background(sight.image, sight.mask if sight.whole is None else sight.whole)
        return FaceTexture(image, everywhere.astype(np.float32), everywhere, None)
    size = ground.texels or settings.size
    texture = texture_face(head, sight, size, settings.texture, np.random.default_rng(settings.seed))
    return texture if ground.lids is None else replace(texture, image=draw_lid_lines(texture.image, head, ground.lids))


def _find_head(picture: HeadPicture, pixels: np.ndarray) -> ParsedHead:
    """The head in a picture by its mask, or else by its colours. Raises InputError where there is none.

    pixels: (H, W) bool, those that the face's mesh covers.
    """
    mask = picture.mask
    if mask is None:
        mask = mask_head(picture.face, picture.image)
    elif not (mask & pixels).any():
        raise InputError("expected a mask that is white where the head is, found none there")
    return ParsedHead(mask, mask)
