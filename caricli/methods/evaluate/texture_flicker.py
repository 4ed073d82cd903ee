"""How steadily the texture of a take changes (expressions paper, section 4.4)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch

from caricli.data.texture_set import ActedTextures
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.evaluate.evaluate_texture import Painter
from caricli.methods.train.texture.texture_losses import TextureBatch
from caricli.methods.train.texture.texture_pairs import PairChoice, TexturePairs, painted_people
from caricli.models.texture.config import TextureConfig

FRAMES = 9
"""From the neutral face to an expression."""


def takes_of(people: Sequence[ActedTextures], grid: ChartGrid) -> list[TextureBatch]:
    """A take of each person: FRAMES rows, from the neutral face, whose texture is the source, to the next expression.

    Shapes and weights go straight from one to the other. grid: ChartGrid of the size that painters take.
    """
    config = TextureConfig(size=grid.size, looks=0, mirrored=0)
    pairs = TexturePairs(painted_people([_take(person) for person in people], grid, config), grid, config)
    frames = np.arange(FRAMES)
    nothing = np.zeros(FRAMES, int)
    bright = np.ones((FRAMES, 1, 1, 3))
    rows = [np.full(FRAMES, number) for number in range(len(people))]
    return [pairs.batch(PairChoice(row, row, nothing, nothing, frames, bright, paired=True)) for row in rows]


def _take(person: ActedTextures) -> ActedTextures:
    """A person whose expressions are the frames."""
    share = np.linspace(0, 1, FRAMES, dtype=np.float32)
    way = person.vertices[1] - person.neutral
    return replace(
        person,
        pictures=np.repeat(person.pictures[:1], FRAMES, axis=0),
        seen=np.repeat(person.seen[:1], FRAMES, axis=0),
        weights=share[:, None] * person.weights[1],
        vertices=person.neutral + share[:, None, None] * way,
    )


@torch.no_grad()
def flicker(painter: Painter, takes: Sequence[TextureBatch]) -> float:
    """How much a texture turns back from frame to frame, in percent of how much it changes over two frames.

    takes: each a batch whose rows are frames. 0 where textures go straight from one to another; about 170 where each
    frame changes by chance. Mean over all texels of all frames but the outer ones.
    """
    turned = 0.0
    changed = 0.0
    for take in takes:
        frames = painter(take)
        turned += float((frames[2:] - 2 * frames[1:-1] + frames[:-2]).abs().sum())
        changed += float((frames[2:] - frames[:-2]).abs().sum())
    return 100 * turned / max(changed, 1e-12)
