"""How far faces from sketches are from the true ones: a network, the fit of a linear model, and the mean face."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from caricli.errors import InputError, shown
from caricli.methods.evaluate.sketch_fit import NOISES, SketchFit
from caricli.methods.train.sketch_hand import DrawnLines, Missing, SketchHand
from caricli.methods.train.stages import Report, unwatched
from caricli.models.linear_model import LinearModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel
from caricli.models.sketch.networks import CAMERA
from caricli.template.feature_curves import FeatureCurve
from caricli.template.template import Template

FACE_HEIGHT = 200.0
"""Millimetres that the face region of the mean head is high (sketch paper, section 6.3)."""

CONDITIONS = {
    "clean": (0.0, Missing()),
    "noise": (1.0, Missing()),
    "half": (1.0, Missing(1.0, 0.5)),
}
"""How sketches are drawn: strength of what hands do, and what is missing; half: with noise, without half of the
strokes."""

LEFT = (1.0, 0.75, 0.5, 0.35, 0.2, 0.1)
"""Shares of strokes that are left, of the curve over them; with noise."""

NETWORK = "network"
UNNAMED = "network, strokes without names"
KNOWN = "fit of the linear model, camera known"
FREE = "fit of the linear model, camera free"
MEAN = "mean face"


@dataclass(eq=False)
class SketchFigures:
    """What an evaluation comes to.

    errors: millimetres by method and condition. left: millimetres of the network by the share of strokes left. noises:
    that were chosen for the fits, by method and condition. maps: (V,) millimetres by method, where on the head the
    errors are with noise.
    """

    errors: dict[str, dict[str, float]] = field(default_factory=dict)
    left: dict[float, float] = field(default_factory=dict)
    noises: dict[str, dict[str, float]] = field(default_factory=dict)
    maps: dict[str, np.ndarray] = field(default_factory=dict)

    def as_json(self) -> dict:
        """Without the maps."""
        left = {f"{share:g}": value for share, value in self.left.items()}
        return {"millimetres": self.errors, "noise_of_fits": self.noises, "millimetres_by_strokes_left": left}


@dataclass(frozen=True, eq=False)
class SketchRivals:
    """A network, the linear model whose latents it tells, and a hand that draws for it."""

    network: SketchModel
    model: LinearModel
    hand: SketchHand

    @classmethod
    def of(cls, network: SketchModel, model: ShapeModel, curves: tuple[FeatureCurve, ...]) -> "SketchRivals":
        """curves: of the model's head.

        Raises InputError where the model is not linear, or a curve that the network knows is not among them.
        """
        if not isinstance(model, LinearModel):
            raise InputError(f"expected a linear model, found {model.kind}")
        by_name = {curve.name: curve for curve in curves}
        lacking = [name for name in network.curves if name not in by_name]
        if lacking:
            raise InputError(
                f"expected a head with the curve {shown(lacking[0], 60)}, which the network draws, found none"
            )
        return cls(network, model, SketchHand([by_name[name] for name in network.curves], network.size))

    def draw(self, vertices: np.ndarray, strength: float, missing: Missing, seed: list[int]) -> DrawnLines:
        """Sketches of faces (N, V, 3)."""
        generator = np.random.default_rng(seed)
        return self.hand.draw(vertices[:, self.hand.ids], np.full(len(vertices), strength), missing, generator)

    def see(self, drawn: DrawnLines) -> np.ndarray:
        """What the network makes of sketches: latents (N, D)."""
        batch = self.hand.batch(drawn)
        return self.network.read(batch.windows, batch.points)[:, :-CAMERA]

    def fit(self, fit: SketchFit, drawn: DrawnLines, noise: float, camera_given: bool) -> np.ndarray:
        """What the fit makes of them: latents (N, D)."""
        return np.stack([fit.fit(drawn, row, noise, camera_given) for row in range(len(drawn.lines))])


def unit(template: Template) -> float:
    """Millimetres of the tables to a metre of the head."""
    face = template.vertices[template.region("face")]
    return FACE_HEIGHT / float(np.ptp(face[:, 1]))


def evaluate_sketch(
    rivals: SketchRivals, tested: np.ndarray, others: np.ndarray, seed: int = 0, report: Report = unwatched
) -> SketchFigures:
    """Measure all methods on faces.

    tested: (N, V, 3) metres. others: (M, V, 3) of further people, on whom the noise of the fits is chosen; where there
    are none it is the middle one. seed: of the drawing.
    """
    figures = SketchFigures()
    fit = SketchFit(rivals.model, rivals.hand)
    total = len(CONDITIONS) + len(LEFT)
    for done, (name, (strength, missing)) in enumerate(CONDITIONS.items()):
        report(done, total)
        drawn = rivals.draw(tested, strength, missing, [seed, done])
        tries = rivals.draw(others, strength, missing, [seed, 100 + done]) if len(others) else None
        nameless = replace(drawn, named=np.zeros(len(tested), bool))
        latents = {NETWORK: rivals.see(drawn), UNNAMED: rivals.see(nameless)}
        for method, given in ((KNOWN, True), (FREE, False)):
            noise = _chosen(rivals, fit, tries, others, given)
            figures.noises.setdefault(method, {})[name] = noise
            latents[method] = rivals.fit(fit, drawn, noise, given)
        latents[MEAN] = np.zeros_like(latents[NETWORK])
        for method, own in latents.items():
            apart = _apart(rivals.model, own, tested)
            figures.errors.setdefault(method, {})[name] = float(apart.mean())
            if name == "noise":
                figures.maps[method] = apart.mean(0)
    for done, share in enumerate(LEFT, len(CONDITIONS)):
        report(done, total)
        drawn = rivals.draw(tested, 1.0, Missing(1.0, 1 - share), [seed, 200 + done])
        figures.left[share] = float(_apart(rivals.model, rivals.see(drawn), tested).mean())
    report(total, total)
    return figures


def _chosen(rivals: SketchRivals, fit: SketchFit, drawn: DrawnLines | None, vertices: np.ndarray, given: bool) -> float:
    """The noise with which the fits of drawn faces are nearest to them."""
    if drawn is None:
        return NOISES[len(NOISES) // 2]
    error: Callable[[float], float] = lambda noise: float(  # noqa: E731
        _apart(rivals.model, rivals.fit(fit, drawn, noise, given), vertices).mean()
    )
    return min(NOISES, key=error)


def _apart(model: LinearModel, latents: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Distances (N, V) of vertices from the true ones, without alignment, millimetres of the tables."""
    return unit(model.template) * np.linalg.norm(model.decode(latents) - vertices, axis=-1)


def rows(figures: Mapping[str, Mapping[str, float]]) -> list[tuple[str, ...]]:
    """Cells of a table of errors by method and condition."""
    return [(method, *(f"{own[name]:.2f}" for name in CONDITIONS)) for method, own in figures.items()]
