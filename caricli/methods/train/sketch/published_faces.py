"""The faces that published sketch networks are trained with: those of a grid, and others between pairs of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.evenly import evenly
from caricli.data.face_grid import face_grid
from caricli.data.held_out import held_out, held_out_together
from caricli.errors import InputError
from caricli.methods.train.sketch.sketch_faces import batches
from caricli.methods.train.sketch.sketch_hand import LINE, Missing, SketchHand
from caricli.methods.train.sketch.wrinkle_book import WrinkleBook
from caricli.methods.train.stages import Report, unwatched
from caricli.models.bilinear.model import BilinearModel
from caricli.models.bilinear.space import BilinearSpace
from caricli.models.sketch.config import SketchConfig
from caricli.models.sketch.published import shown_points
from caricli.models.sketch.window import POINTS
from caricli.seeds import TrainingSeed


@dataclass(frozen=True, eq=False)
class PublishedFaces:
    """N faces, the first M of which are of datasets, the others between pairs of those.

    positions: (N, I, 3) metres, of the vertices that a hand draws. codes: (N, D) of the bilinear model. rows: (N, R)
    what they are in its basis, see ``weighted_rows``. person, expression: (M,) numbers from 0; an exaggerated person
    counts as another one. book: wrinkle lines of all, or None. unseen, unseen_book: (K, V, 3) metres and the lines of
    those that are validated with.
    """

    positions: np.ndarray
    codes: np.ndarray
    rows: np.ndarray
    person: np.ndarray
    expression: np.ndarray
    book: WrinkleBook | None
    unseen: np.ndarray
    unseen_book: WrinkleBook | None

    @classmethod
    def of(
        cls,
        datasets: Sequence[Dataset],
        model: BilinearModel,
        hand: SketchHand,
        config: SketchConfig,
        report: Report = unwatched,
    ) -> Self:
        """The faces of the training split that are not held out. report: told of heads whose wrinkles are found.

        Raises InputError where there are none to train or to validate with.
        """
        vertices, person, expression = _own(datasets, config)
        codes = np.concatenate([model.encode(part.astype(float)) for part in batches(vertices)])
        generator = np.random.default_rng([config.seed, TrainingSeed.EXTRA])
        codes = np.concatenate([codes, model.between(codes, config.extra, generator)])
        between = [model.decode(part).astype(np.float32) for part in batches(codes[len(vertices) :])]
        everything = np.concatenate([vertices, *between])
        unseen = _unseen(datasets, config)
        wrinkled = config.published is not None and config.published.wrinkles
        books = [WrinkleBook.of(model.template, heads, report) if wrinkled else None for heads in (everything, unseen)]
        weights = importance(model, hand, config.importance)
        rows = [weighted_rows(model, part.astype(float), weights) for part in batches(everything)]
        positions = everything[:, hand.ids]
        return cls(positions, codes, np.concatenate(rows), person, expression, books[0], unseen, books[1])


def importance(model: BilinearModel, hand: SketchHand, most: float) -> np.ndarray:
    """(V,) how much vertices count: ``most`` on the curves, 1 elsewhere, then 1 in the mean (equation 2)."""
    weights = np.ones(len(model.template.vertices))
    weights[hand.ids] = most
    return weights / weights.mean()


def weighted_rows(model: BilinearModel, vertices: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Rows (N, R) of the basis that come nearest to vertices (N, V, 3), by the weights (V,) of equation 2."""
    flat = model.basis.reshape(len(model.basis), -1)
    heavy = flat * np.repeat(weights, 3)
    return np.linalg.solve(heavy @ flat.T, heavy @ vertices.reshape(len(vertices), -1).T).T


def point_space(dataset: Dataset, hand: SketchHand, model: BilinearModel) -> BilinearSpace:
    """The bilinear model of points along the curves of a grid of faces, on the canvas, from the front.

    Its dimensions are those of the model of the faces (sketch paper, section 4.3). Raises InputError where the training
    split is no full grid.
    """
    rows = face_grid(dataset, np.flatnonzero(dataset.rows("train"))).rows
    points = drawn_points(dataset.vertices[rows.ravel()], hand)
    space = model.space
    table = shown_points(points).reshape(*rows.shape, -1)
    return BilinearSpace.train(table, space.identity, space.core.shape[2])


def drawn_points(vertices: np.ndarray, hand: SketchHand) -> np.ndarray:
    """(N, K, P, 2) points that a steady hand draws of heads (N, V, 3) from the front."""
    nobody = np.random.default_rng(0)
    lines = [
        hand.draw(part[:, hand.ids].astype(float), np.zeros(len(part)), Missing(), nobody).lines
        for part in batches(vertices)
    ]
    return np.concatenate(lines)[:, :, :: (LINE - 1) // (POINTS - 1)]


def _own(datasets: Sequence[Dataset], config: SketchConfig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, numbers of people and of expressions."""
    parts = []
    who = []
    together = held_out_together(datasets, config.held, config.seed)
    for number, (data, own) in enumerate(zip(datasets, together, strict=True)):
        rows = own["train"]
        parts.append(data.vertices[rows])
        who.append(np.stack([np.full(len(rows), number), data.identity[rows], data.level[rows], data.expression[rows]]))
    columns = np.concatenate(who, 1)
    if not columns.shape[1]:
        raise InputError("expected a dataset with faces of the train split, found none")
    person = np.unique(columns[:3], axis=1, return_inverse=True)[1].ravel()
    expression = np.unique(columns[3], return_inverse=True)[1].ravel()
    return np.concatenate(parts), person, expression


def _unseen(datasets: Sequence[Dataset], config: SketchConfig) -> np.ndarray:
    """Faces that are held out to validate with; where none are, those of the people of the validation split."""
    share = -(-config.validation // len(datasets))
    parts = []
    for data in datasets:
        rows = held_out(data, config.held, config.seed)["validation"]
        rows = rows if len(rows) else np.flatnonzero(data.rows("validation"))
        parts.append(data.vertices[np.array(evenly(rows.tolist(), share), int)])
    if not sum(map(len, parts)):
        raise InputError("expected a dataset with people of the validation split, found none")
    return np.concatenate(parts)
