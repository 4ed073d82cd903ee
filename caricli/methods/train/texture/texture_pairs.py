"""Pairs of expressions of the same people, drawn for the texture network."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import torch

from caricli.data.texture_set import ActedTextures
from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.mouth_parts import MouthParts
from caricli.methods.dynamic.shape_maps import CHANNELS, PersonShapes, ShapeFields, pair_attention, pair_maps
from caricli.methods.dynamic.styles import StyleBook
from caricli.methods.train.stages import Report, unwatched
from caricli.methods.train.texture.texture_losses import TextureBatch
from caricli.models.texture.config import TextureConfig
from caricli.models.texture.networks import OPEN
from caricli.structures.arkit import ARKIT_NAMES
from caricli.template.head import load_head
from caricli.template.template import Template

MIRRORED_ACTIONS = [
    ARKIT_NAMES.index(name.replace("Left", "Right") if "Left" in name else name.replace("Right", "Left"))
    for name in ARKIT_NAMES
]
"""Which action each of ARKit's is in a mirror."""

UNSEEN = 0.2
"""Weight of a texel that one of the pictures did not show."""

BRIGHT = (0.8, 1.2)
"""Range of what the three colours of a pair are multiplied by."""


@dataclass(frozen=True, eq=False)
class PaintedPeople:
    """P people with E expressions each, in L looks, in a chart of S texels.

    pictures: (P, L, E, S, S, 3) uint8 sRGB, the own look first. seen: (P, E, S, S) bool, what pictures truly showed.
    codes: (P, E, 52) ARKit weights. shapes: ShapeFields of (P, E) shapes. numbers: (P,) who they are in their dataset:
    the same one may be there at several levels.
    """

    pictures: np.ndarray
    seen: np.ndarray
    codes: np.ndarray
    shapes: ShapeFields
    numbers: np.ndarray


@dataclass(frozen=True, eq=False)
class PairChoice:
    """B pairs. person: (B,) whose source it is. other: (B,) whose target, the same person's or anybody's. look: (B,) of
    both. source, target: (B,) expressions. bright: (B, 1, 1, 3), what colours are multiplied by. paired: whether all
    targets are the same person's."""

    person: np.ndarray
    other: np.ndarray
    look: np.ndarray
    source: np.ndarray
    target: np.ndarray
    bright: np.ndarray
    paired: bool


class TexturePairs:
    """Draws batches of pairs of PaintedPeople."""

    def __init__(self, people: PaintedPeople, grid: ChartGrid, config: TextureConfig) -> None:
        """grid: ChartGrid of the pictures. config: ``plain``, ``mouth`` and ``relative``."""
        self.people = people
        self.grid = grid
        self.config = config

    @property
    def topology_id(self) -> str:
        """Of the people's meshes."""
        return self.grid.chart.topology_id

    @property
    def count(self) -> int:
        """People."""
        return len(self.people.pictures)

    def draw(self, count: int, generator: np.random.Generator, paired: bool) -> TextureBatch:
        """Pairs of different expressions of random people in random looks; without pairs targets are of others."""
        looks, expressions = self.people.pictures.shape[1:3]
        person = generator.integers(self.count, size=count)
        look = np.where(generator.random(count) < self.config.plain, 0, generator.integers(looks, size=count))
        source = generator.integers(expressions, size=count)
        target = (source + generator.integers(1, expressions, count)) % expressions
        bright = generator.uniform(*BRIGHT, (count, 1, 1, 3))
        other = person if paired else generator.permutation(person)
        batch = self.batch(PairChoice(person, other, look, source, target, bright, paired))
        return mirrored(batch, torch.from_numpy(generator.random(count) < self.config.mirrored))

    def batch(self, choice: "PairChoice") -> TextureBatch:
        """The pairs of a choice."""
        pictures = self.people.pictures
        person = choice.person
        look = choice.look
        shapes = [self.people.shapes[person, each] for each in (choice.source, choice.target)]
        seen = self.people.seen[person, choice.source] & self.people.seen[choice.other, choice.target]
        moved = pair_attention(self.grid, shapes[0], shapes[1])
        return TextureBatch(
            _channels_first(_brightened(pictures[person, look, choice.source], choice.bright)),
            _channels_first(_brightened(pictures[choice.other, look, choice.target], choice.bright)),
            _channels_first(pair_maps(self.grid, shapes[0], shapes[1])),
            _channels_first(pair_maps(self.grid, shapes[1], shapes[0])),
            torch.from_numpy(self.people.codes[person, choice.source]),
            torch.from_numpy(self.people.codes[person, choice.target]),
            torch.from_numpy(OPEN + (1 - OPEN) * moved if self.config.relative else moved)[:, None],
            torch.from_numpy(self._weight(seen & self.grid.covered))[:, None],
            torch.from_numpy(seen & self.grid.covered)[:, None],
            torch.from_numpy(person),
            choice.paired,
        )

    def _weight(self, seen: np.ndarray) -> np.ndarray:
        """(B, S, S) how much texels count. seen: (B, S, S)."""
        part = np.where(self.grid.mouth, self.config.mouth, 1.0) * self.grid.covered
        return ((UNSEEN + (1 - UNSEEN) * seen) * part / part.mean()).astype(np.float32)


def painted_people(
    people: Sequence[ActedTextures],
    grid: ChartGrid,
    config: TextureConfig,
    styles: StyleBook | None = None,
    seed: Sequence[int] = (),
    report: Report = unwatched,
) -> PaintedPeople:
    """Paint people in ``config.looks`` styles beside their own look, and see their shapes in the chart.

    styles: StyleBook that looks are drawn from; None for the own look alone. seed: of these, with the stream of what
    people are for (LookSeed): the same one gives the same looks, in whatever order. report: called with people done
    and all.
    Raises InputError where there is nobody, or pictures are smaller than the grid's.
    """
    if not people:
        raise InputError("expected people with textures, found none")
    head = load_head().template()
    looks = []
    seen = []
    shapes = []
    for number, one in enumerate(people):
        generator = np.random.default_rng([*seed, _mark(one)])
        own = np.stack([_fitted(picture, grid.size) for picture in one.pictures])
        drawn = [] if styles is None else [styles.draw(generator) for _ in range(config.looks)]
        looks.append(np.stack([own, *(style.paint(own) for style in drawn)]))
        seen.append(np.stack([_fitted(255 * mask.astype(np.uint8), grid.size) > 127 for mask in one.seen]))
        shapes.append(_shapes(one, grid, head))
        report(number + 1, len(people))
    codes = np.stack([one.weights for one in people])
    numbers = np.array([one.person for one in people])
    return PaintedPeople(np.stack(looks), np.stack(seen), codes, ShapeFields.stacked(shapes), numbers)


def _mark(person: ActedTextures) -> int:
    """A number of somebody's textures: with another look, or at another level, somebody has another one."""
    return int.from_bytes(hashlib.sha256(person.pictures.tobytes()).digest()[:8], "big")


def mirrored(batch: TextureBatch, which: torch.Tensor) -> TextureBatch:
    """Some people of a batch, which (B,) bool says, as a mirror shows them: the chart is symmetric."""
    sides = torch.tensor([-1.0 if name.endswith("_x") else 1.0 for name in CHANNELS])[:, None, None]

    def turned(values: torch.Tensor) -> torch.Tensor:
        return torch.where(which[:, None, None, None], values.flip(-1), values)

    def turned_maps(values: torch.Tensor) -> torch.Tensor:
        return torch.where(which[:, None, None, None], values.flip(-1) * sides, values)

    def swapped(codes: torch.Tensor) -> torch.Tensor:
        return torch.where(which[:, None], codes[:, MIRRORED_ACTIONS], codes)

    return replace(
        batch,
        source=turned(batch.source),
        target=turned(batch.target),
        forth=turned_maps(batch.forth),
        back=turned_maps(batch.back),
        source_code=swapped(batch.source_code),
        target_code=swapped(batch.target_code),
        moved=turned(batch.moved),
        weight=turned(batch.weight),
        seen=turned(batch.seen),
    )


def _shapes(person: ActedTextures, grid: ChartGrid, head: Template) -> ShapeFields:
    """Of all expressions. head: Template of the open head, whose topology people of a dataset have."""
    neutral = np.asarray(person.neutral, float)
    mouth = MouthParts.in_face(head.with_vertices(neutral), person.vertices - neutral)
    shapes = PersonShapes(grid, neutral, mouth)
    rows = np.eye(len(person.vertices))
    return ShapeFields.stacked([shapes.fields(one, row) for one, row in zip(person.vertices, rows, strict=True)])


def _fitted(picture: np.ndarray, size: int) -> np.ndarray:
    """A square picture at a smaller size."""
    if len(picture) < size:
        raise InputError(f"expected textures of at least {size} texels, found {len(picture)}")
    return cv2.resize(picture, (size, size), interpolation=cv2.INTER_AREA)


def _brightened(pictures: np.ndarray, bright: np.ndarray) -> np.ndarray:
    """Pictures (B, S, S, 3) uint8 as numbers from 0 to 1, their colours multiplied by (B, 1, 1, 3)."""
    return np.minimum(pictures / 255 * bright, 1).astype(np.float32)


def _channels_first(pictures: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(pictures).permute(0, 3, 1, 2)
