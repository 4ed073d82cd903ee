"""A portrait made a caricature: its shape, and what it is painted with."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.stylise.exaggerate_portrait import ShapeTools, exaggerate_portrait
from caricli.methods.stylise.mesh_warp import mesh_warp
from caricli.methods.stylise.paint_picture import paint_picture
from caricli.methods.stylise.settings import StyliseSettings
from caricli.structures import Landmarks

Generator = Callable[[np.ndarray], np.ndarray]
"""A user's own painter: (H, W, 3) uint8 to the same shape, with the face where it was."""


@dataclass(frozen=True, eq=False)
class Stylised:
    """A stylised portrait.

    picture: (H, W, 3) uint8. landmarks: of the face in it, as many as were given; exact, because they went the way of
    the pixels. warped: (H, W, 3) uint8, its shape without paint. moved: percent of the diagonal of the given landmarks,
    how far they went on average.
    """

    picture: np.ndarray
    landmarks: Landmarks
    warped: np.ndarray
    moved: float


def stylise_portrait(
    image: np.ndarray,
    marks: Landmarks,
    tools: ShapeTools | None,
    settings: StyliseSettings = StyliseSettings(),  # noqa: B008 (frozen)
    generator: Generator | None = None,
) -> Stylised:
    """Give a portrait the shape of a caricature, and paint it (portrait paper, section 3, where a StyleGAN does both).

    A face is reconstructed from the landmarks and exaggerated (``exaggerate_portrait``), the picture follows its mesh
    (``mesh_warp``) and is painted (``paint_picture``).
    image: (H, W, 3) uint8. marks: Landmarks of the face in it, known or not. tools: what shapes are made with; None
    where the shape is "none" or the strength 0. settings: StyliseSettings. generator: what paints in place of the
    style, or None.
    Returns Stylised. Raises InputError, NumericsError.
    """
    warped = image
    landmarks = replace(marks, spreads=None, visibility=None)
    if tools is not None and settings.shape != "none" and settings.strength > 0:
        fit = fit_landmarks(marks.head_points, tools.model, spreads=marks.spreads)
        vertices = exaggerate_portrait(fit, tools, settings.shape, settings.strength)
        size = (image.shape[1], image.shape[0])
        warp = mesh_warp(fit.face, vertices, tools.model.template, size, settings.warp)
        warped = warp.picture(image)
        points = warp.points(marks.points)
        slides = None if marks.slides is None else np.nan_to_num(warp.points(marks.head_points) - points)
        landmarks = Landmarks(points, size, slides=slides)
    paint = generator or partial(
        paint_picture, marks=landmarks, style=settings.style, generator=np.random.default_rng(settings.seed)
    )
    moved = np.linalg.norm(landmarks.points - marks.points, axis=1)[marks.known].mean()
    return Stylised(paint(warped), landmarks, warped, float(100 * moved / marks.diagonal))
