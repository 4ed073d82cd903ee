"""How far faces from sketches are from the true ones: networks, the fit of a linear model, and the mean face."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from caricli.data.evenly import evenly
from caricli.errors import InputError, shown
from caricli.methods.evaluate.sketch_fit import NOISES, SketchFit
from caricli.methods.sketch.see_sketch import see_lines
from caricli.methods.train.sketch.sketch_hand import (
    CALM,
    Canvas,
    DrawnLines,
    HandSettings,
    Missing,
    SketchHand,
    Wrinkles,
)
from caricli.methods.train.sketch.wrinkle_book import WrinkleBook
from caricli.methods.train.stages import Report, unwatched
from caricli.models.linear_model import LinearModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel
from caricli.template.feature_curves import feature_curves
from caricli.template.template import Template

FACE_HEIGHT = 200.0
"""Millimetres that the face region of the mean head is high (sketch paper, section 6.3)."""


@dataclass(frozen=True)
class Drawing:
    """How sketches are drawn. strength: of what hands do. missing: Missing. hand: HandSettings."""

    strength: float = 1.0
    missing: Missing = Missing()
    hand: HandSettings = HandSettings()


CONDITIONS = {
    "clean": Drawing(0.0),
    "noise": Drawing(),
    "half": Drawing(missing=Missing(1.0, 0.5)),
    "calm": Drawing(hand=CALM),
}
"""Half: with noise, without half of the strokes; calm: with the noise of view, scale and place, but lines of a calm
hand."""

LEFT = (1.0, 0.75, 0.5, 0.35, 0.2, 0.1)
"""Shares of strokes that are left, of the curve over them; with noise."""

UNSEEN = "people of no training"
TENTH = "random tenth"
"""Protocols: who is measured; the second is the paper's, with people who were trained with."""

UNNAMED = ", strokes without names"
KNOWN = "fit of the linear model, camera known"
FREE = "fit of the linear model, camera free"
MEAN = "mean face"


@dataclass(eq=False)
class SketchFigures:
    """What an evaluation comes to.

    errors: millimetres by method and condition. left: millimetres by network and the share of strokes left. noises:
    that were chosen for the fits, by method and condition. maps: (V,) millimetres by method, where on the head the
    errors are with noise.
    """

    errors: dict[str, dict[str, float]] = field(default_factory=dict)
    left: dict[str, dict[float, float]] = field(default_factory=dict)
    noises: dict[str, dict[str, float]] = field(default_factory=dict)
    maps: dict[str, np.ndarray] = field(default_factory=dict)

    def as_json(self) -> dict:
        """Without the maps."""
        left = {name: {f"{share:g}": value for share, value in own.items()} for name, own in self.left.items()}
        return {"millimetres": self.errors, "noise_of_fits": self.noises, "millimetres_by_strokes_left": left}


@dataclass(frozen=True, eq=False)
class SketchRival:
    """A network, the model whose latents it tells, and a hand that draws for it."""

    network: SketchModel
    model: ShapeModel
    hand: SketchHand

    @classmethod
    def of(cls, network: SketchModel, model: ShapeModel) -> "SketchRival":
        """model: whose latents the network tells. Raises InputError where its head lacks a curve of the network's."""
        by_name = {curve.name: curve for curve in feature_curves(model.template.annotation)}
        lacking = [name for name in network.curves if name not in by_name]
        if lacking:
            raise InputError(
                f"expected a head with the curve {shown(lacking[0], 60)}, which the network draws, found none"
            )
        curves = [by_name[name] for name in network.curves]
        canvas = Canvas.of(model.decode(model.prior.mean), curves) if network.on_canvas else None
        return cls(network, model, SketchHand(curves, network.size, canvas))

    def draw(self, heads: "DrawnHeads", drawing: Drawing, seed: list[int]) -> DrawnLines:
        """Sketches of heads; the same seed draws the same for all networks."""
        generator = np.random.default_rng(seed)
        positions = heads.vertices[:, self.hand.ids]
        wrinkles = heads.book.of_rows(np.arange(len(positions))) if self.network.wrinkled and heads.book else None
        return _drawn(self.hand, positions, drawing, generator, wrinkles)

    def see(self, drawn: DrawnLines) -> np.ndarray:
        """What the network makes of sketches: vertices (N, V, 3)."""
        batch = self.hand.batch(drawn)
        latents, _ = see_lines(batch.windows, batch.points, self.network, self.model)
        return self.model.decode(latents)

    def shown(self, heads: "DrawnHeads", seed: int) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
        """Sketches of heads with noise, (N, S, S) uint8 ink, and vertices that the network sees beside true ones."""
        drawn = self.draw(heads, Drawing(), [seed, 300])
        return self.hand.batch(drawn).windows, list(zip(self.see(drawn), heads.vertices, strict=True))


@dataclass(frozen=True, eq=False)
class SketchRivals:
    """Networks by what tables call them, and the fit of a linear model, with a hand that draws for it."""

    networks: dict[str, SketchRival]
    fit: SketchFit
    hand: SketchHand

    @classmethod
    def of(cls, networks: Sequence[SketchRival], model: LinearModel) -> "SketchRivals":
        """networks: at least one. model: to fit."""
        names: dict[str, SketchRival] = {}
        for rival in networks:
            label = rival.network.label
            several = sum(name.split(" (")[0] == label for name in names)
            names[f"{label} ({several + 1})" if several else label] = rival
        hand = SketchHand(networks[0].hand.curves, networks[0].hand.size)
        return cls(names, SketchFit(model, hand), hand)

    @property
    def model(self) -> LinearModel:
        """What is fitted."""
        return self.fit.model

    @property
    def first(self) -> SketchRival:
        """The first network."""
        return next(iter(self.networks.values()))

    @property
    def wrinkled(self) -> bool:
        """Whether a network looks at wrinkles."""
        return any(rival.network.wrinkled for rival in self.networks.values())

    def draw(self, vertices: np.ndarray, drawing: Drawing, seed: list[int]) -> DrawnLines:
        """Sketches of faces (N, V, 3) for the fits."""
        return _drawn(self.hand, vertices[:, self.hand.ids], drawing, np.random.default_rng(seed))

    def fitted(self, drawn: DrawnLines, noise: float, camera_given: bool) -> np.ndarray:
        """What the fit makes of them: vertices (N, V, 3)."""
        rows = range(len(drawn.lines))
        return self.model.decode(np.stack([self.fit.fit(drawn, row, noise, camera_given) for row in rows]))


@dataclass(frozen=True, eq=False)
class DrawnHeads:
    """Heads (N, V, 3) metres, and their wrinkle lines where somebody looks at them."""

    vertices: np.ndarray
    book: WrinkleBook | None = None

    @classmethod
    def of(cls, vertices: np.ndarray, rivals: SketchRivals, report: Report = unwatched) -> "DrawnHeads":
        """Heads (N, V, 3), with wrinkles where one of the rivals looks at them. report: told of heads looked at."""
        wrinkles = WrinkleBook.of(rivals.model.template, vertices, report) if rivals.wrinkled else None
        return cls(vertices.astype(float), wrinkles)

    def some(self, count: int) -> "DrawnHeads":
        """At most ``count`` of them, evenly over all."""
        rows = np.array(evenly(range(len(self.vertices)), count))
        return DrawnHeads(self.vertices[rows], self.book and self.book.some(rows))


def unit(template: Template) -> float:
    """Millimetres of the tables to a metre of the head."""
    face = template.vertices[template.region("face")]
    return FACE_HEIGHT / float(np.ptp(face[:, 1]))


def evaluate_sketch(
    rivals: SketchRivals, tested: DrawnHeads, others: np.ndarray, seed: int = 0, report: Report = unwatched
) -> SketchFigures:
    """Measure all methods on faces.

    tested: DrawnHeads. others: (M, V, 3) metres of further faces, on which the noise of the fits is chosen; where there
    are none it is the middle one. seed: of the drawing.
    """
    figures = SketchFigures()
    total = len(CONDITIONS) + len(LEFT)
    for done, condition in enumerate(CONDITIONS):
        report(done, total)
        for method, vertices in _seen(rivals, tested, condition, [seed, done]):
            _note(figures, rivals, method, condition, (vertices, tested.vertices))
        for method, vertices, noise in _fits(rivals, tested.vertices, others, condition, [seed, done]):
            figures.noises.setdefault(method, {})[condition] = noise
            _note(figures, rivals, method, condition, (vertices, tested.vertices))
        mean = np.broadcast_to(rivals.model.mean, tested.vertices.shape)
        _note(figures, rivals, MEAN, condition, (mean, tested.vertices))
    for done, share in enumerate(LEFT, len(CONDITIONS)):
        report(done, total)
        for method, rival in rivals.networks.items():
            drawn = rival.draw(tested, Drawing(missing=Missing(1.0, 1 - share)), [seed, 200 + done])
            apart = _apart(rivals.model.template, rival.see(drawn), tested.vertices)
            figures.left.setdefault(method, {})[share] = float(apart.mean())
    report(total, total)
    return figures


def _seen(
    rivals: SketchRivals, tested: DrawnHeads, condition: str, seed: list[int]
) -> Iterator[tuple[str, np.ndarray]]:
    """Every network's name and what it makes of the sketches of a condition: vertices."""
    for method, rival in rivals.networks.items():
        drawn = rival.draw(tested, CONDITIONS[condition], seed)
        yield method, rival.see(drawn)
        if not rival.network.on_canvas:
            yield f"{method}{UNNAMED}", rival.see(replace(drawn, named=np.zeros(len(drawn.named), bool)))


def _fits(
    rivals: SketchRivals, tested: np.ndarray, others: np.ndarray, condition: str, seed: list[int]
) -> Iterator[tuple[str, np.ndarray, float]]:
    """Every fit's name, vertices, and the noise with which the fits of other faces are nearest to them."""
    drawing = CONDITIONS[condition]
    drawn = rivals.draw(tested, drawing, seed)
    tries = rivals.draw(others, drawing, [seed[0], 100 + seed[1]]) if len(others) else None
    for method, given in ((KNOWN, True), (FREE, False)):
        noise = NOISES[len(NOISES) // 2]
        if tries is not None:
            errors = [
                _apart(rivals.model.template, rivals.fitted(tries, each, given), others).mean() for each in NOISES
            ]
            noise = NOISES[int(np.argmin(errors))]
        yield method, rivals.fitted(drawn, noise, given), noise


def _drawn(
    hand: SketchHand,
    positions: np.ndarray,
    drawing: Drawing,
    generator: np.random.Generator,
    wrinkles: Wrinkles | None = None,
) -> DrawnLines:
    """Lines of heads, see SketchHand.draw."""
    own = SketchHand(hand.curves, hand.size, hand.canvas, drawing.hand)
    return own.draw(positions, np.full(len(positions), drawing.strength), drawing.missing, generator, wrinkles)


def _note(
    figures: SketchFigures, rivals: SketchRivals, method: str, condition: str, pair: tuple[np.ndarray, np.ndarray]
) -> None:
    apart = _apart(rivals.model.template, *pair)
    figures.errors.setdefault(method, {})[condition] = float(apart.mean())
    if condition == "noise":
        figures.maps[method] = apart.mean(0)


def _apart(template: Template, vertices: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Distances (N, V) of vertices from the true ones, without alignment, millimetres of the tables."""
    return unit(template) * np.linalg.norm(vertices - true, axis=-1)


def rows(figures: Mapping[str, Mapping[str, float]]) -> list[tuple[str, ...]]:
    """Cells of a table of errors by method and condition."""
    return [(method, *(f"{own[name]:.2f}" for name in CONDITIONS)) for method, own in figures.items()]
