"""The training of a stroke network, on sketches that are drawn as they are needed."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from torch.nn import functional

from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.sketch.sketch_hand import DrawnLines, Missing, SketchHand
from caricli.methods.train.sketch.wrinkle_book import WrinkleBook
from caricli.methods.train.stages import Report, unwatched
from caricli.methods.train.strokes.drawn_page import Page, draw_page
from caricli.models.strokes.config import StrokesConfig
from caricli.models.strokes.networks import StrokeNetwork
from caricli.models.strokes.places import Places, line_picture
from caricli.seeds import TrainingSeed
from caricli.structures.sketch import CANVAS
from caricli.template.feature_curves import named_curves


@dataclass(frozen=True, eq=False)
class PlaceBatch:
    """Sketches of a step.

    windows: (B, 1, S, S) ink from 0 to 1. places: (B, P, 4), see ``networks.ABOUT``. classes: (B, P) what they draw, 0
    for no curve.
    """

    windows: torch.Tensor
    places: torch.Tensor
    classes: torch.Tensor


@dataclass(frozen=True, eq=False)
class _Heads:
    """Heads that sketches are drawn of: the vertices of their curves (N, I, 3), metres, and their wrinkles."""

    positions: np.ndarray
    wrinkles: WrinkleBook


class StrokesTraining(NetworkTraining):
    """Training of a StrokeNetwork, as every NetworkTraining, by cross entropy at places along strokes.

    Every sketch is drawn anew: a face of the datasets as a hand draws it, changed as artists change faces, with what
    people draw beside it. Errors are shares of the places, 0 to 1, that are taken for something else.
    """

    def __init__(
        self,
        datasets: Sequence[Dataset],
        config: StrokesConfig,
        share: Share = ALL,
        report: Report = unwatched,
    ) -> None:
        """datasets: of one topology; people of their validation splits are validated with. report: of wrinkles.

        Raises InputError when nobody is there to train or to validate with, or the head has no curves.
        """
        template = datasets[0].template
        self.hand = SketchHand(named_curves(template.annotation), config.size)
        self.curves = tuple(curve.name for curve in self.hand.curves)
        super().__init__(partial(StrokeNetwork, config.network(), 1 + len(self.curves)), config, share)
        train = [data.vertices[data.rows("train")] for data in datasets]
        unseen = [data.vertices[spread_rows(data.rows("validation"), config.validation)] for data in datasets]
        for name, parts in (("train", train), ("validation", unseen)):
            if not sum(map(len, parts)):
                raise InputError(f"expected a dataset with people of the {name} split, found none")
        both = np.concatenate([*train, *unseen])
        wrinkles = WrinkleBook.of(template, both, report)
        count = sum(map(len, train))
        rows = np.arange(len(both))
        self.heads, self.unseen = (
            _Heads(both[part][:, self.hand.ids].astype(float), wrinkles.some(part))
            for part in (rows[:count], rows[count:][:: max(1, (len(both) - count) // config.validation)])
        )

    def _draw(self, step: int) -> PlaceBatch:
        """This process's sketches of a step."""
        numbers = self.share.rows(self.config.batch)
        seeds = [[self.config.seed, TrainingSeed.STEP, self.epoch, step, number] for number in numbers]
        return self._batch([self._page(self.heads, None, np.random.default_rng(seed)) for seed in seeds], seeds)

    def _page(self, heads: _Heads, row: int | None, generator: np.random.Generator) -> Page:
        """A page of some head, or of any."""
        head = int(generator.integers(len(heads.positions))) if row is None else row
        strength = np.array([self.config.strength * generator.uniform(0, 2)])
        wrinkles = heads.wrinkles.of_rows(np.array([head]))
        drawn = self.hand.draw(
            heads.positions[head : head + 1], strength, Missing(self.config.missing), generator, wrinkles
        )
        curves, creases = _on_canvas(drawn, self.curves)
        return draw_page(curves, creases, generator)

    def _batch(self, pages: Sequence[Page], seeds: Sequence[Sequence[int]]) -> PlaceBatch:
        """What the network is shown of pages, and of each as many places, drawn by its seed."""
        config = self.config
        windows = [line_picture(page.lines, page.window, config.size) for page in pages]
        about = []
        classes = []
        for page, seed in zip(pages, seeds, strict=True):
            places = Places.of(page.lines, page.window)
            own = np.array([self._class(name) for name in page.names])[places.owner]
            generator = np.random.default_rng([*seed, 1])
            chosen = generator.choice(len(own), config.points, replace=len(own) < config.points)
            about.append(places.about[chosen])
            classes.append(own[chosen])
        ink = torch.from_numpy(np.stack(windows)[:, None]).float() / 255
        return PlaceBatch(ink, torch.from_numpy(np.stack(about)), torch.from_numpy(np.stack(classes)))

    def _class(self, curve: str | None) -> int:
        return 0 if curve is None else 1 + self.curves.index(curve)

    def _loss(self, drawn: PlaceBatch) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of places, and the share of them that are taken for something else."""
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bfloat16"):
            logits = self.network(drawn.windows, drawn.places)
        logits = logits.float().flatten(0, 1)
        classes = drawn.classes.flatten()
        return functional.cross_entropy(logits, classes), (logits.detach().argmax(1) != classes).float().mean()

    @torch.inference_mode()
    def _validate(self) -> float:
        """Share of the places of sketches of unseen people that are taken for something else."""
        self.average.eval()
        wrong = []
        for row in range(len(self.unseen.positions)):
            seed = [self.config.seed, TrainingSeed.VALIDATION, row]
            batch = self._batch([self._page(self.unseen, row, np.random.default_rng(seed))], [seed])
            logits = self.average(batch.windows, batch.places)
            wrong.append(float((logits.argmax(2) != batch.classes).float().mean()))
        return float(np.mean(wrong))


def _on_canvas(drawn: DrawnLines, names: Sequence[str]) -> tuple[dict[str, np.ndarray], list[np.ndarray]]:
    """The curves of the only sketch of a batch by their names, and its wrinkles, pixels of a canvas."""
    middle = (CANVAS - 1) / 2
    curves = {
        name: middle * (1 + line)
        for name, line, there in zip(names, drawn.lines[0], drawn.there[0], strict=True)
        if there
    }
    assert drawn.creases is not None and drawn.creased is not None
    return curves, [middle * (1 + line) for line in drawn.creases[0][drawn.creased[0]]]
