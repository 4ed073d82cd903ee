"""Where everything lies in the picture of a head, to paint over."""

import colorsys

import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt

from caricli.errors import InputError
from caricli.render.sheets.contact_sheet import legible
from caricli.render.visibility.uv_map import uv_map
from caricli.template.template import Template

_PAPER = 255
_BARE = (232, 232, 232)  # sRGB of what no region names
_WIRE = (120, 120, 120)
_SEAM = (190, 30, 30)
_INK = (25, 25, 25)
_SHIFT = 4  # bits of a pixel that lines are drawn to
_WHOLE = 0.5  # of a region's texels that a later one takes: then its name would stand on another's
_WRITING = 1 / 64  # of the picture's side


def uv_sheet(template: Template, size: int = 2048) -> np.ndarray:
    """Draw the layout of a template: its regions in colours with their names, its polygons, seams in red.

    It fits the textures of the template as a layer above them. Regions on both sides share a colour; left and right are
    the subject's.

    template: with UVs. size: pixels, width and height.
    Returns (size, size, 3) uint8. Raises InputError when the template has no UVs.
    """
    if template.uvs is None or template.uv_polygons is None:
        raise InputError("a sheet of UVs needs a mesh with UVs, found one without")
    face = uv_map(template, size)[0]
    regions = _regions(template)
    image = np.full((size, size, 3), _PAPER, np.uint8)
    image[face >= 0] = _BARE
    for name, triangles in regions.items():
        image[triangles[face] & (face >= 0)] = _colour(name, list(regions))
    _draw_lines(image, template)
    _write_names(image, {name: triangles[face] & (face >= 0) for name, triangles in regions.items()})
    return image


def _regions(template: Template) -> dict[str, np.ndarray]:
    """(F,) bool by region, the large ones first, without those that are all made of others."""
    annotated = template.annotation.regions
    masks = {name: template.mask(name)[template.faces].all(1) for name in annotated}
    order = sorted((name for name in masks if masks[name].any()), key=lambda name: (-masks[name].sum(), name))
    kept = []
    for k, name in enumerate(order):
        finer = np.any([masks[other] for other in order[k + 1 :]], axis=0) & masks[name]
        if finer.sum() < _WHOLE * masks[name].sum():
            kept.append(name)
    return {name: masks[name] for name in kept}


def _colour(name: str, names: list[str]) -> tuple[float, ...]:
    """A light sRGB colour, the same for both sides, far from that of the next name."""
    plain = sorted({_one_side(other) for other in names})
    hue = plain.index(_one_side(name)) * 0.381966 % 1  # the golden section never comes near where it was
    return tuple(255 * c for c in colorsys.hls_to_rgb(hue, 0.82, 0.6))


def _one_side(name: str) -> str:
    return name.removesuffix("_left").removesuffix("_right")


def _draw_lines(image: np.ndarray, template: Template) -> None:
    """Polygons, and over them the borders of the charts."""
    size = len(image)
    assert template.uvs is not None and template.uv_polygons is not None
    # OpenCV counts from the middle of the first pixel.
    places = (template.uvs * [1, -1] + [0, 1]) * size - 0.5
    places = np.round(places * 2**_SHIFT).astype(np.int32)
    polygons = [row[row >= 0] for row in template.uv_polygons]
    cv2.polylines(image, [places[row] for row in polygons], True, _WIRE, 1, cv2.LINE_AA, _SHIFT)
    edges = np.concatenate([np.stack([row, np.roll(row, -1)], axis=1) for row in polygons])
    edges, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    thick = max(1, size // 1024)
    cv2.polylines(image, list(places[edges[counts == 1]]), False, _SEAM, thick, cv2.LINE_AA, _SHIFT)


def _write_names(image: np.ndarray, areas: dict[str, np.ndarray]) -> None:
    """Every name where its region is widest; where that leaves a choice, as high and as far left as can be."""
    from PIL import Image, ImageDraw, ImageFont

    size = len(image)
    font = ImageFont.load_default(max(8, round(size * _WRITING)))
    picture = Image.fromarray(image)
    pen = ImageDraw.Draw(picture)
    taken = np.zeros(image.shape[:2], bool)
    for name, area in reversed(areas.items()):
        # Small regions speak first; a large one then leaves them out.
        depth = distance_transform_edt(np.pad(area & ~taken, 1))[1:-1, 1:-1]
        row, column = np.unravel_index(depth.argmax(), depth.shape)
        text = legible(name.replace("_", " "))
        half = font.getlength(text) / 2 + 2
        at = (float(np.clip(column, half, size - half)), float(row))
        pen.text(at, text, _INK, font, anchor="mm", stroke_width=max(1, size // 1024), stroke_fill=(255, 255, 255))
        taken |= area
    image[:] = np.asarray(picture)
