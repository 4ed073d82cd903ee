"""A face from a sketch at one look: what the network makes of it."""

import numpy as np

from caricli.models.linear_model import LinearModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel, window_camera
from caricli.models.sketch.networks import CAMERA
from caricli.structures import Face
from caricli.structures.sketch import Sketch

_TURNED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0])
"""What a mirror makes of the six numbers of a camera."""


def see_sketch(sketch: Sketch, network: SketchModel, basis: ShapeModel) -> Face:
    """The face of a sketch (sketch paper, section 5.1, initial sketching).

    Strokes with names of curves count by their places, too; others by the picture alone.

    network: SketchModel. basis: ShapeModel whose latents it tells, as ``load_sketch_pair`` gives both.
    Returns Face with camera, in pixels of the sketch's canvas, and latent. Raises InputError where nothing is drawn.
    """
    ink, points, window = network.look(sketch)
    (latent,), (numbers,) = see_lines(ink[None], points[None], network, basis)
    mesh = basis.template.with_vertices(basis.decode(latent))
    return Face(mesh, window_camera(numbers, window), latent=latent, model_id=basis.model_id)


def see_lines(
    windows: np.ndarray, points: np.ndarray, network: SketchModel, basis: ShapeModel
) -> tuple[np.ndarray, np.ndarray]:
    """Latents (N, D) and cameras (N, 6), see ``CAMERA``, of lines in windows (N, S, S) uint8, and points (N, K, P, 2).

    They are the means of what the network sees in the lines and in their mirror image, so that the mirror image of a
    sketch is that of its face; published networks look once.
    """
    numbers = network.read(windows, points)
    latents = numbers[:, :-CAMERA]
    cameras = numbers[:, -CAMERA:]
    mirror = basis.template.annotation.mirror
    if network.on_canvas or mirror is None or not isinstance(basis, LinearModel):
        return latents, cameras
    turned = network.read(np.ascontiguousarray(windows[:, :, ::-1]), network.mirrored(points))
    faces = basis.decode(turned[:, :-CAMERA])[:, mirror] * [-1.0, 1.0, 1.0]
    return (latents + basis.encode(faces)) / 2, (cameras + _TURNED * turned[:, -CAMERA:]) / 2
