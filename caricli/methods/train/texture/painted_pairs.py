"""Generated faces with what they look like in a medium: what a style network is trained on and measured with."""

from dataclasses import dataclass

import numpy as np

from caricli.data.appearance import random_appearance
from caricli.methods.dynamic.lit_faces import LitFaces
from caricli.methods.dynamic.media import NAMES, random_medium
from caricli.methods.pictures.light import random_sky
from caricli.methods.train.stages import Report, unwatched
from caricli.template.template import Template

TEXELS = 128
"""Sides of the pictures."""


@dataclass(frozen=True, eq=False)
class PaintedPairs:
    """N faces.

    plain: (N, S, S, 3) uint8. painted: the same in a medium. other: the same people in another light and the same
    medium, with strokes elsewhere, which is what the style of ``painted`` is told by. media: (N,) numbers in NAMES.
    """

    plain: np.ndarray
    painted: np.ndarray
    other: np.ndarray
    media: np.ndarray


def painted_pairs(template: Template, count: int, seed: tuple[int, int], report: Report = unwatched) -> PaintedPairs:
    """Draw PaintedPairs of a template with UVs.

    seed: of the training and of the stream. report: called with faces that are drawn, and of how many.
    """
    faces = LitFaces(template, TEXELS)
    rows = []
    for number in range(count):
        generator = np.random.default_rng([*seed, number])
        appearance = random_appearance(generator)
        medium = random_medium(generator)
        plain, other = (faces.draw(appearance, random_sky(generator)) for _ in range(2))
        # Mirrored, so that strokes are elsewhere on the face.
        mirrored = np.ascontiguousarray(other[:, ::-1])
        rows.append((plain, medium.paint(plain), medium.paint(mirrored), NAMES.index(medium.name)))
        report(number + 1, count)
    plains, painted, others, media = zip(*rows, strict=True)
    return PaintedPairs(np.stack(plains), np.stack(painted), np.stack(others), np.array(media))
