"""Draw where the 68 and the 81 landmarks stand, with their numbers: draw_landmarks.py [PICTURE]."""

import sys
from pathlib import Path

import numpy as np
from matplotlib import font_manager
from PIL import Image, ImageDraw, ImageFont

from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.render.face_look import head_look
from caricli.render.sheets.overlay import draw_landmarks, overlay_mesh
from caricli.render.views import TO_PICTURE
from caricli.structures import Camera
from caricli.structures.landmarks import BROWS, COUNT, EXTRA, EYE_LEFT, EYE_RIGHT, JAW, LIPS, LIPS_INSIDE, NOSTRILS
from caricli.template.head import load_head

MOUTH = {"jawOpen": 0.4, "mouthLowerDownLeft": 0.3, "mouthLowerDownRight": 0.3}
"""Opens it, so that the inner lips part."""

SIDE = 900
"""Pixels of one of the two pictures."""

REACH = 17
"""Pixels between a point and the middle of its number."""

INK = (0, 70, 160)


def draw(target):
    """Write both pictures beside each other."""
    head = load_head()
    template = head.template()
    face = template.with_vertices(head.evaluate(actions=MOUTH))
    font = ImageFont.truetype(font_manager.findfont("DejaVu Sans:bold"), 17)
    vertices = face.vertices[landmark_vertices(face.vertices, TO_PICTURE, template, len(template.annotation.landmarks))]
    sheet = Image.new("RGB", (2 * SIDE, SIDE), "white")
    for k, (shown, numbers) in enumerate(((vertices[:COUNT], range(COUNT)), (vertices, EXTRA))):
        picture, points = portray(face, shown)
        pen = ImageDraw.Draw(picture)
        for number, (x, y) in zip(numbers, points[numbers] + REACH * away(points)[numbers], strict=True):
            pen.text((x, y), str(number), INK, font, "mm", stroke_width=3, stroke_fill="white")
        sheet.paste(picture, (k * SIDE, 0))
    sheet.save(target, quality=88, optimize=True)


def portray(face, shown):
    """A picture that shows points (L, 3) of a face, drawn as dots, and where (L, 2) they are in it."""
    low, high = (extreme(shown, axis=0)[:2] for extreme in (np.min, np.max))
    scale = 0.84 * SIDE / np.max(high - low)
    middle = (low + high) / 2
    camera = Camera(scale, TO_PICTURE, SIDE / 2 - scale * TO_PICTURE[:2, :2] @ middle)
    paper = np.full((SIDE, SIDE, 3), 255, np.uint8)
    whole, look = head_look(face)
    picture = overlay_mesh(paper, whole, camera, 1.0, look)
    points = camera.place(shown)[:, :2]
    return Image.fromarray(draw_landmarks(picture, points, radius=4)), points


def away(points):
    """Unit vectors (L, 2) towards where a number covers neither its point's neighbours nor its line."""
    ways = np.tile([1.0, 0.0], (len(points), 1))
    for ring in (EYE_RIGHT, EYE_LEFT, LIPS, LIPS_INSIDE):
        ways[ring] = points[ring] - points[ring].mean(0)
    ways[LIPS_INSIDE] *= -1
    # Six of them stand closer than their numbers are wide.
    ways[61:64] = [[-0.8, 0.6], [0, 1], [0.8, 0.6]]
    ways[65:68] = [[0.8, -0.6], [0, -1], [-0.8, -0.6]]
    ways[JAW] = points[JAW] - points[27]
    ways[BROWS] = [0, -1]
    ways[NOSTRILS] = [0, 1]
    ways[COUNT:] = points[COUNT:] - points[27]
    return ways / np.linalg.norm(ways, axis=1, keepdims=True)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images" / "landmarks.jpg")
