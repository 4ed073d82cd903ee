"""Blendshapes of caricatures whose true expressions are known (expressions paper, section 4.2.1)."""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from caricli.data.build_settings import Exaggeration
from caricli.data.dataset import Dataset
from caricli.data.evenly import evenly
from caricli.data.expressions import NEUTRAL, named_expressions
from caricli.errors import InputError, naming
from caricli.geometry.alignment.head_rotation import TURNS, head_rotation
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.evaluate.paired_interval import paired_interval
from caricli.methods.expressions.build_blendshapes import Blendshapes, build_blendshapes
from caricli.methods.expressions.measure_blendshapes import measure_blendshapes
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.train.stages import Report, unwatched
from caricli.structures import Camera, Face
from caricli.template.template import Template

RIVALS = {
    "full": ("full", "intrinsic"),
    "initial": ("initial", "intrinsic"),
    "initial, latent": ("initial", "latent"),
    "transfer": ("transfer", "intrinsic"),
}
"""What is compared: ``method`` and ``reconstruct`` of BlendshapeSettings."""

STEADY = ("scalp", "ear_left", "ear_right", "temple_left", "temple_right")
"""Regions of the annotation that expressions are not meant to move, skin on bone and cartilage: drift is of these,
where no mask has a say."""

TRUTH = "truth"
"""What rivals are measured against, among them."""

GIVEN = ("neutral", "any")
"""Which expression the pictures of caricatures show: none, or a random one."""

PICTURED = 400.0
"""Pixels that a head is high in its picture; landmarks have no pixels, so that it hardly matters."""

Figures = dict[str, dict]
"""By rival: error, drift, drift_off, strength, strength_off, excess (K,), structure, flipped, and seconds."""


@dataclass(frozen=True, eq=False)
class KnownCaricature:
    """identity and level of a caricature in a dataset; truth (K, V, 3) metres, with every expression, neutral first."""

    identity: int
    level: int
    truth: np.ndarray


@dataclass(frozen=True, eq=False)
class Comparison:
    """What came of one caricature.

    face: Face as it was given, with the camera of its picture.
    figures: by rival, TRUTH among them, (K,), NaN for the given expression: error, and drift, the mean displacement of
    STEADY, percent of the head's height; drift_off, the same of the difference from the true displacement, which for a
    face that keeps still is the truth's drift; strength, of the normal face's; strength_off, how far from the truth's;
    excess, percent of the normal face's mean displacement; and structure; flipped, percent of triangles, at most;
    seconds.
    blendshapes: Blendshapes by rival.
    """

    face: Face
    figures: Figures
    blendshapes: dict[str, Blendshapes]


@dataclass(frozen=True, eq=False)
class ComparisonTally:
    """Figures of all caricatures so far. expressions: K names, neutral first."""

    expressions: list[str]
    caricatures: list[KnownCaricature] = field(default_factory=list)
    figures: list[Figures] = field(default_factory=list)

    def add(self, caricature: KnownCaricature, comparison: Comparison) -> None:
        """Count a caricature."""
        self.caricatures.append(caricature)
        self.figures.append(comparison.figures)

    @property
    def summary(self) -> dict:
        """JSON object: means, differences, expressions (see ``by_expression``), and the figures of all caricatures."""
        each = [
            {"person": caricature.identity, "level": caricature.level, "rivals": _finite(figures, self.expressions)}
            for caricature, figures in zip(self.caricatures, self.figures, strict=True)
        ]
        parts = {"means": self.means, "differences": self.differences, "expressions": self.by_expression}
        return parts | {"caricatures": each}

    @property
    def means(self) -> dict[str, dict[str, float]]:
        """Mean figures by rival."""
        return {
            name: {key: float(np.nanmean([f[name][key] for f in self.figures])) for key in first}
            for name, first in self.figures[0].items()
        }

    @property
    def differences(self) -> dict[str, dict[str, float]]:
        """By rival: the error of "full" less its own, of all expressions, paired over caricatures, and intervals."""
        errors = {name: np.nanmean(own, axis=1) for name, own in self._errors.items()}
        rivals = {name: own for name, own in errors.items() if name != "full"}
        return {name: paired_interval(errors["full"] - own, self._people) for name, own in rivals.items()}

    @property
    def by_expression(self) -> dict[str, dict]:
        """By expression: mean error by rival; on how many caricatures "full" is nearest to the truth; of how many; and
        the error of "full" less that of "transfer" with its interval.
        """
        errors = self._errors
        best = np.min([errors[name] for name in RIVALS if name != "full"], axis=0)
        nearest = (errors["full"] < best).sum(0)
        compared = np.isfinite(best).sum(0)
        means = {
            name: np.where(compared, np.nansum(own, 0) / np.maximum(compared, 1), np.nan)
            for name, own in errors.items()
        }
        return {
            name: {rival: own[k] for rival, own in means.items() if np.isfinite(own[k])}
            | {"full_is_nearest_on": int(nearest[k]), "of": int(compared[k])}
            | {"beside_transfer": paired_interval((errors["full"] - errors["transfer"])[:, k], self._people)}
            for k, name in enumerate(self.expressions)
        }

    @property
    def _errors(self) -> dict[str, np.ndarray]:
        """(N, K) by rival."""
        return {name: np.array([f[name]["error"] for f in self.figures]) for name in RIVALS}

    @property
    def _people(self) -> np.ndarray:
        return np.array([caricature.identity for caricature in self.caricatures])


def dataset_expressions(data: Dataset, action_names: Sequence[str]) -> dict[str, dict[str, float]]:
    """The named expressions of a generated Dataset, neutral first: weights of actions by name.

    Raises InputError where the names are not those of the bundled table, or the neutral one is missing or alone.
    """
    table = named_expressions(action_names)
    names = data.manifest.get("expressions", [])
    if NEUTRAL not in names or not set(names) <= set(table):
        raise InputError("expected a dataset of caricli dataset build, with a neutral expression, found another")
    if set(names) == {NEUTRAL}:
        raise InputError(f"expected expressions to compare, found {NEUTRAL} alone; build more with --expressions")
    return {name: table[name] for name in (NEUTRAL, *(name for name in names if name != NEUTRAL))}


def dataset_caricatures(data: Dataset, count: int = 50) -> list[KnownCaricature]:
    """Test people of a Dataset as caricatures, at most ``count``, of whom every expression is there.

    Raises InputError where there are none.
    """
    caricatures = known_caricatures(data, sorted(data.manifest["splits"]["test"]))
    if not caricatures:
        raise InputError("expected caricatures with every expression, found none; build one without --count")
    return evenly(caricatures, count)


def known_caricatures(data: Dataset, people: Iterable[int]) -> list[KnownCaricature]:
    """KnownCaricatures of a Dataset: exaggerated people of whom every expression is there.

    Meshes that are exaggerated at random, each in a way of its own, are nobody's expressions.
    """
    names = data.manifest["expressions"]
    columns = (data.identity.tolist(), data.level.tolist(), data.expression.tolist())
    kinds = data.factors.get("kind", np.zeros(len(data.level)))
    alike = kinds <= Exaggeration.CURVATURE
    rows = {key: row for row, key in enumerate(zip(*columns, strict=True)) if alike[row]}
    order = sorted(range(len(names)), key=lambda k: names[k] != NEUTRAL)
    caricatures = []
    for identity in people:
        for level in sorted(set(data.level[data.identity == identity].tolist()) - {1}):
            keys = [(identity, level, k) for k in order]
            if all(key in rows for key in keys):
                truth = data.vertices[[rows[key] for key in keys]].astype(np.float64)
                caricatures.append(KnownCaricature(int(identity), int(level), truth))
    return caricatures


def evaluate_blendshapes(
    caricatures: Sequence[KnownCaricature],
    tools: ExpressionTools,
    given: str = GIVEN[0],
    seed: int = 0,
    report: Report = unwatched,
) -> Iterator[tuple[KnownCaricature, Comparison]]:
    """Compare the rivals on caricatures, each seen once from a random side.

    tools: of the same expressions, with a model of latents. given: of GIVEN, what the pictures show. report: called
    with the caricatures done and all.
    Yields each with what came of it. Raises InputError, NumericsError.
    """
    generator = np.random.default_rng(seed)
    for done, caricature in enumerate(caricatures):
        shows = 0 if given == NEUTRAL else int(generator.integers(len(caricature.truth)))
        camera = random_camera(generator, np.ptp(caricature.truth[shows][:, 1]))
        with naming(f"person {caricature.identity}, level {caricature.level}"):
            comparison = compare_blendshapes(caricature.truth, shows, camera, tools)
        yield caricature, comparison
        report(done + 1, len(caricatures))


def random_camera(generator: np.random.Generator, height: float) -> Camera:
    """A Camera in which a head of a height in metres is seen, turned a little."""
    rotation = head_rotation(generator.uniform(-1, 1, 3) * TURNS)
    return Camera(PICTURED / height, rotation, np.array([PICTURED, PICTURED]))


def compare_blendshapes(truth: np.ndarray, given: int, camera: Camera, tools: ExpressionTools) -> Comparison:
    """Build the expressions of a known caricature by every method and measure them.

    truth: (K, V, 3) metres. given: number of the expression that the picture shows. tools: of the same expressions,
    with a model of latents.
    """
    template = tools.morphable.template
    face = Face(template.with_vertices(truth[given]), camera)
    built = {}
    seconds = {}
    for name, (method, reconstruct) in RIVALS.items():
        start = time.perf_counter()
        built[name] = build_blendshapes(face, tools, BlendshapeSettings(method, reconstruct))
        seconds[name] = {"seconds": time.perf_counter() - start}
    built = {TRUTH: replace(built["transfer"], shapes=truth)} | built
    others = np.arange(len(truth)) != given
    figures = {name: rival_figures(own, truth, others, face, template) for name, own in built.items()}
    return Comparison(face, {name: own | seconds.get(name, {}) for name, own in figures.items()}, built)


def rival_figures(
    blendshapes: Blendshapes, truth: np.ndarray, others: np.ndarray, face: Face, template: Template
) -> dict:
    """The figures of one rival, as in ``Comparison``, without its seconds.

    truth: (K, V, 3) metres. others: (K,) bool, expressions that were not given. face: Face as it was given.
    """
    height = face.mesh.height
    moves = blendshapes.shapes - face.vertices
    true_moves = truth - face.vertices
    normal = blendshapes.normal - blendshapes.normal_given
    measures = measure_blendshapes(moves, normal)
    steady = template.mask(*STEADY)

    def percent(ways: np.ndarray) -> np.ndarray:
        return 100 * np.linalg.norm(ways, axis=2).mean(1) / height

    each = {
        "error": percent(moves - true_moves),
        "drift": percent(moves[:, steady]),
        "drift_off": percent((moves - true_moves)[:, steady]),
        "strength": measures.strength,
        "strength_off": np.abs(measures.strength - measure_blendshapes(true_moves, normal).strength),
        "excess": 100 * measures.excess,
    }
    flipped = 100 * max(flipped_triangles(shape, template.gradients).mean() for shape in blendshapes.shapes)
    figures = {key: np.where(others, values, np.nan) for key, values in each.items()}
    return figures | {"structure": measures.structure, "flipped": flipped}


def _finite(figures: Figures, names: list[str]) -> Figures:
    """Figures by rival, those of expressions by name; what is not a number is left out."""
    return {
        rival: {
            key: {n: float(v) for n, v in zip(names, value, strict=True) if np.isfinite(v)} if np.ndim(value) else value
            for key, value in own.items()
        }
        for rival, own in figures.items()
    }
