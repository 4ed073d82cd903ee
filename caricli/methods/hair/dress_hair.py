"""The hair of a picture on the head that was fitted to it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.methods.hair.face_size import face_size
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.mask_hair import HairMask, mask_hair
from caricli.methods.hair.move_skull import sink_skull
from caricli.methods.hair.paint_hair import paint_hair
from caricli.methods.hair.parsed_hair import is_before_head, on_head, parsed_hair
from caricli.methods.hair.snap_border import snap_border
from caricli.methods.texture.another_colour import lab_colours
from caricli.methods.texture.mask_head import mesh_pixels
from caricli.methods.texture.picture_view import PictureView, Sight
from caricli.methods.texture.settings import PaintSettings
from caricli.render.pixels.distance_to import distance_to
from caricli.render.pixels.smaller_mask import smaller_mask
from caricli.structures import Camera, Face, Hair
from caricli.structures.parsing import HEAD_REGIONS, Region
from caricli.template.annotation import EARS
from caricli.template.template import Template

_NEEDED = (*EARS, "scalp")
_AROUND = 0.1  # of the head's height: farther from head and hair a picture says nothing of hair
_LIKE = 2 / 3  # overlap of a shell with what colours, or labels far from the head, take for hair; with less it is none
_TORN = 0.5  # of a labelled hat: colours that take less than that of it tear it
_MEET = 0.063  # of the face's size: so near to each other hair and what is behind it meet
_UNLIKE = 12.0  # in CIELAB, between the mean colours there: what is no farther from it than this goes on as a wall
_PIXELS = 750  # height of the head in the picture that a shell is made by at most; its quads are four of them
_SIZE = 1024  # texels of hair where none are asked for


@dataclass(frozen=True, eq=False)
class DressedHair:
    """Hair and what is under it.

    face: Face whose skull is under the hair. hair: Hair on it. mask: HairMask. overlap: intersection over union of
    hair as the camera sees it and the mask, in a picture whose head has at most so many pixels as is fine enough.
    """

    face: Face
    hair: Hair
    mask: HairMask
    overlap: float

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        return {"doubt": self.mask.doubt, "overlap": self.overlap}


def dress_hair(
    face: Face,
    template: Template,
    image: np.ndarray,
    settings: PaintSettings,
    regions: np.ndarray | None = None,
    pixels: np.ndarray | None = None,
) -> DressedHair | None:
    """Put the hair of a picture on a head.

    face: Face with camera and landmarks. template: of its topology. image: (H, W, 3) uint8. settings: PaintSettings;
    their hair is "shell", "auto" for none where it is doubtful which pixels show hair or the template does not name
    ears and scalp, or "none". regions: (H, W) values of Region, what the pixels show, or None to tell hair by its
    colours, which also do where these contradict the regions, but for what is labelled neck or cloth. Where most of
    what is labelled hair is beside the head, it is hair if it has an edge and a shell is like it. pixels: (H, W) bool,
    those that the face's mesh covers, or None to find them.
    Returns DressedHair, or None. Raises InputError where a shell is asked for and there is no hair or no such name.
    """
    if not _wants_hair(template, settings):
        return None
    pixels = mesh_pixels(face, image) if pixels is None else pixels
    if regions is not None:
        mask = parsed_hair(face, regions, pixels, image)
        if mask is not None and is_before_head(mask, pixels):
            return _put_on(face, template, mask, settings)
        # A wall that is labelled hair, or a wig, which has an edge, and which a shell is like.
        if mask is not None and _stands_out(face, mask, image):
            dressed = _put_on(face, template, mask, replace(settings, hair="auto"))
            if dressed is not None and dressed.overlap >= _LIKE:
                return dressed
    mask = mask_hair(face, template, image)
    dressed = _put_on(face, template, mask if regions is None else _as_labelled(mask, regions, pixels), settings)
    if dressed is not None and settings.hair == "auto" and dressed.overlap < _LIKE:
        return None
    return dressed


def _put_on(face: Face, template: Template, mask: HairMask, settings: PaintSettings) -> DressedHair | None:
    """A head in the hair of a mask; for the other arguments, None and what is raised see `dress_hair`."""
    if settings.hair == "auto" and not mask.trusted:
        return None
    if not mask.pixels.any():
        raise InputError("expected hair around the face, found none; --hair none goes without")
    head = template.with_vertices(face.vertices)
    camera, near = _near(head, face.require_camera(), mask)
    shell = make_shell(sink_skull(head, camera, near), camera, near)
    if shell is None:
        if settings.hair == "auto":
            return None
        raise InputError("expected hair on the scalp, found none there; --hair none goes without")
    hair, head, overlap = snap_border(*shell, camera, near)
    sunk = replace(face, mesh=face.mesh.with_vertices(head.vertices), residual=None)
    return DressedHair(sunk, hair, mask, overlap)


def hair_picture(dressed: DressedHair, image: np.ndarray, settings: PaintSettings) -> np.ndarray:
    """(S, S, 3) uint8, the picture of the hair that a head is dressed in. image: (H, W, 3) uint8, what it is from."""
    sight = Sight(dressed.face.require_camera(), image, dressed.mask.pixels)
    view = PictureView(dressed.hair.shell, sight, settings.texture)
    return paint_hair(dressed.hair, view, settings.size or _SIZE, np.random.default_rng(settings.seed))


def _as_labelled(mask: HairMask, regions: np.ndarray, pixels: np.ndarray) -> HairMask:
    """What of a mask by colours is labelled neither neck nor cloth, in regions (H, W), and hangs on a head (H, W) bool.

    Hoods go over into collars and shoulders. White hair may well be labelled skin, but not where most of the mask is of
    hat and hair: then skin is none of it, and where little of the hat, and of both, is in it, it is shreds of a hat and
    not trusted.
    """
    hat, worn = (on_head(np.isin(regions, parts), pixels) for parts in ((Region.HAT,), (Region.HAT, Region.HAIR)))
    told = (mask.pixels & worn).sum() > mask.pixels.sum() / 2
    other = (*HEAD_REGIONS, Region.CLOTH) if told else (Region.NECK, Region.CLOTH)
    own = on_head(mask.pixels & ~np.isin(regions, other), pixels)
    torn = told and all((own & part).sum() < _TORN * part.sum() for part in (hat, worn))
    return replace(mask, pixels=own, behind=mask.behind | (regions == Region.CLOTH), trusted=mask.trusted and not torn)


def _stands_out(face: Face, mask: HairMask, image: np.ndarray) -> bool:
    """Whether hair has another colour than what is behind it, where they meet."""
    reach = _MEET * face_size(face)
    hair = mask.pixels & (distance_to(mask.behind) < reach)
    behind = mask.behind & (distance_to(mask.pixels) < reach)
    if not (hair.any() and behind.any()):
        return False
    colours = [lab_colours(image, part).mean(0) for part in (hair, behind)]
    return bool(np.linalg.norm(colours[0] - colours[1]) > _UNLIKE)


def _near(head: Template, camera: Camera, mask: HairMask) -> tuple[Camera, HairMask]:
    """A mask's part around head and hair, all that a shell is made by, no larger than is fine enough for it, and the
    camera of such a picture."""
    rows, columns = np.nonzero(mask.pixels)
    places = np.concatenate([camera.project(head.vertices), np.column_stack([columns, rows])])
    size = camera.scale * head.height
    corners = np.array([places.min(0) - _AROUND * size, places.max(0) + _AROUND * size])
    start, end = np.clip(np.round(corners), 0, mask.pixels.shape[::-1]).astype(int)
    part = np.s_[start[1] : end[1], start[0] : end[0]]
    pixels, behind = mask.pixels[part], mask.behind[part]
    zoom = _PIXELS / size
    if zoom < 1:
        pixels, behind = (smaller_mask(each, zoom) for each in (pixels, behind))
    return camera.zoomed(min(zoom, 1.0), start), replace(mask, pixels=pixels, behind=behind)


def _wants_hair(template: Template, settings: PaintSettings) -> bool:
    """Whether a head of a template is to have hair. Raises InputError where it must, and nothing says where."""
    if settings.hair == "none" or settings.project_uv:
        return False
    missing = [name for name in _NEEDED if name not in template.annotation.regions]
    if missing and settings.hair == "shell":
        raise InputError(f"expected an annotation with the region {missing[0]!r} for hair to stand on, found none")
    return not missing
