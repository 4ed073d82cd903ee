"""The training of a texture network in its folder."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import SPLITS
from caricli.data.texture_set import MANIFEST, ActedTextures, TextureSet, read_texture_set
from caricli.data.unseen import strange_splits
from caricli.errors import InputError, naming
from caricli.io.provenance import made_of
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.styles import StyleBook
from caricli.methods.evaluate.evaluate_texture import Judge, Painter, TextureChoice, TextureTally, evaluate_texture
from caricli.methods.evaluate.paint_sheet import paint_sheet
from caricli.methods.evaluate.texture_flicker import flicker, takes_of
from caricli.methods.evaluate.texture_rivals import linear_painter, network_painter, spline_painter, train_reader
from caricli.methods.train.processes import Share
from caricli.methods.train.stages import Report
from caricli.methods.train.texture.texture_losses import TextureBatch
from caricli.methods.train.texture.texture_pairs import TexturePairs, painted_people
from caricli.methods.train.texture.train_texture import TextureTraining
from caricli.models.texture.config import TextureConfig
from caricli.models.texture.model import TextureModel, texture_to_checkpoint
from caricli.seeds import LookSeed
from caricli.store.pictures import pictures_in
from caricli.store.texture_networks import load_texture_network
from caricli.store.training_run import RunFolder
from caricli.structures import SeenPeople
from caricli.template.chart import face_chart
from caricli.template.head import load_head

TAKES = 10
"""People, at most, whose takes are looked at for flicker."""


@dataclass(frozen=True, eq=False)
class TextureIngredients:
    """What a texture network is trained with.

    pairs, unseen: to train and to validate with. drawings: of the unpaired part, or None for ``pairs``.
    """

    pairs: TexturePairs
    unseen: TexturePairs
    drawings: TexturePairs | None

    def training(self, config: TextureConfig, share: Share) -> TextureTraining:
        """The training, from its beginning."""
        return TextureTraining(self.pairs, self.unseen, config, share, self.drawings)


def texture_sources(folders: Sequence[Path], drawings: Path | None, styles: Path | None) -> list[Path]:
    """Files that a training is made of: what says what is in folders of textures, and style pictures."""
    sets = [*folders, *([] if drawings is None else [drawings])]
    pictures = [] if styles is None or not styles.is_dir() else pictures_in(styles)
    return [*(folder / MANIFEST for folder in sets), *pictures]


def load_texture_ingredients(
    folders: Sequence[Path],
    drawings: Path | None,
    config: TextureConfig,
    styles: StyleBook,
    report: Report,
) -> TextureIngredients:
    """People of folders of textures, painted in styles.

    drawings: folder of textures for the unpaired part, or None. styles: StyleBook. report: called with people done and
    all. Raises InputError when a folder is none, damaged, of another topology than the others, of other numbers of
    expressions, or without people to train or to validate with, and for drawings without an unpaired part.
    """
    if drawings is not None and config.paired_epochs == config.epochs:
        settings = f"epochs={config.epochs} and unpaired={config.unpaired:g}"
        raise InputError(f"{drawings}: expected an unpaired part to train on it, found none with {settings}")
    sets = _joinable_sets(folders)
    others = [] if drawings is None else [read_texture_set(drawings)]
    grid = ChartGrid(face_chart(load_head().template()), config.size)
    own, unseen = (
        [person for textures in sets for person in textures.people(split)] for split in ("train", "validation")
    )
    other = [person for textures in others for person in textures.people("train")]
    _require_people(", ".join(map(str, folders)), {"train": own, "validate": unseen})
    if drawings is not None:
        _require_people(str(drawings), {"train": other})
    total = len(own) + len(unseen) + len(other)
    done = 0

    def painted(people: Sequence[ActedTextures], stream: LookSeed) -> TexturePairs:
        nonlocal done
        before = done
        done += len(people)
        seed = (config.seed, stream)
        looks = painted_people(people, grid, config, styles, seed, lambda count, _: report(before + count, total))
        return TexturePairs(looks, grid, config)

    with naming(", ".join(map(str, folders))):
        pairs = painted(own, LookSeed.TRAINING)
        unpaired = None if drawings is None else painted(other, LookSeed.DRAWINGS)
        return TextureIngredients(pairs, painted(unseen, LookSeed.VALIDATION), unpaired)


def _joinable_sets(folders: Sequence[Path]) -> list[TextureSet]:
    """The textures of folders. Raises InputError where people of one have other numbers of expressions."""
    sets = [read_texture_set(folder) for folder in folders]
    for textures in sets:
        if textures.shown != sets[0].shown:
            expected = f"{sets[0].shown} expressions of everybody, as in {folders[0]}"
            raise InputError(f"{textures.folder}: expected {expected}, found {textures.shown}")
    return sets


def _require_people(folders: str, people: dict[str, list[ActedTextures]]) -> None:
    """Refuse folders in which there is nobody for one of the uses, before anything is painted."""
    for use, own in people.items():
        if not own:
            raise InputError(f"{folders}: expected people to {use} with, found none")


class TextureRun(RunFolder):
    """The folder of a texture network's training."""

    curve = "texture error"
    axis = "mean difference in % of that of the texture kept"

    def follow(self, training: TextureTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""

        def checkpoint() -> tuple[dict, dict]:
            model = TextureModel(
                training.copied_average(), training.config.size, training.pairs.topology_id, self.recipe
            )
            return texture_to_checkpoint(model)

        return self.record(training, 1.0, checkpoint)

    def finish(self, training: TextureTraining) -> dict:
        """Write the report of the best model. Returns its figures."""
        model = self.best_model(load_texture_network)
        figures = {"percent_of_kept": 100 * training.best}
        self.report({"model_id": model.model_id, "validation": figures})
        return figures


@dataclass(frozen=True, eq=False)
class TextureTest:
    """What textures of other expressions are measured with.

    painters: by name. judge: that reads expressions. pairs: of people of no training. takes: of some of these.
    """

    painters: dict[str, Painter]
    judge: Judge
    pairs: TexturePairs
    takes: list[TextureBatch]

    def run(self, count: int, seed: int, report: Report) -> TextureTally:
        """Let all paint ``count`` pairs."""
        return evaluate_texture(self.painters, self.judge, self.pairs, TextureChoice(count, seed), report)

    def flicker(self) -> dict[str, float]:
        """By painter, see ``flicker``."""
        return {name: flicker(painter, self.takes) for name, painter in self.painters.items()}

    def sheet(self, rows: int, seed: int) -> np.ndarray:
        """A picture (H, W, 3) uint8: source, target, and what painters make of it, of so many pairs."""
        return paint_sheet(self.painters, self.pairs.draw(rows, np.random.default_rng(seed), paired=True))


@dataclass(frozen=True)
class TextureFolders:
    """Whose textures are compared.

    folder: of textures; rivals learn from its training split. others: folder of those tested, or None for folder's test
    split.
    """

    folder: Path
    others: Path | None = None

    def people(self) -> tuple[list[ActedTextures], list[ActedTextures]]:
        """To learn from and to test with. Raises InputError where others hold somebody who is learnt from."""
        textures = read_texture_set(self.folder)
        own = list(textures.people("train"))
        if self.others is None:
            return own, list(textures.people("test"))
        others = read_texture_set(self.others)
        tested = list(others.people())
        same = others.manifest["splits"] == textures.manifest["splits"]
        learnt = set().union(*(_marks(person, same) for person in own))
        both = sum(not learnt.isdisjoint(_marks(person, same)) for person in tested)
        if both:
            raise InputError(f"{self.others}: expected people whom nobody learnt with, found {both} of {self.folder}")
        return own, tested

    @property
    def tested(self) -> Path:
        """The folder of those tested."""
        return self.others or self.folder

    def learnt_by(self, network: TextureModel) -> bool:
        """Whether a network learnt from somebody who is tested, as far as it and the folder say."""
        if self.others is not None and made_of(network.recipe, self.others / MANIFEST):
            return True
        seen = SeenPeople.of_recipe(network.recipe)
        if seen is None:
            return False
        strange = strange_splits(read_texture_set(self.tested).manifest, seen)
        looked_at = {"test"} if self.others is None else {*SPLITS}
        return not looked_at <= {*strange}


def _marks(person: ActedTextures, same: bool) -> set[Any]:
    """What tells somebody: the shape at rest, and among people of one dataset the number, for another level has another
    shape. same: whether they are of one, as equal splits say; of two of equal size ages differ."""
    return {person.neutral.tobytes()} | ({(person.person, person.age)} if same else set())


def load_texture_test(
    networks: Sequence[Path], textures: TextureFolders, styles: StyleBook, seed: int, report: Report
) -> TextureTest:
    """Networks, or the bundled one where none is given, and the test people of folders of textures.

    styles: StyleBook that people are painted from, beside their own look. seed: of the looks, and of what learns.
    report: called with people done and all. Raises InputError where a network is of another size than the others, or
    nobody is there to test or to learn with.
    """
    models = {str(path): load_texture_network(path) for path in networks} or {"network": load_texture_network()}
    sizes = {model.size for model in models.values()}
    if len(sizes) > 1:
        raise InputError(f"expected networks for charts of one size, found {', '.join(map(str, sorted(sizes)))}")
    config = TextureConfig(size=sizes.pop(), seed=seed, mirrored=0)
    head = load_head().template()
    for name, model in models.items():
        if model.topology_id != head.topology_id:
            raise InputError(f"{name}: expected a texture network of the head's mesh, found one of another")
    learnt, tested = textures.people()
    for name, model in models.items():
        if textures.learnt_by(model):
            raise InputError(f"{textures.tested}: expected people of no training, found what {name} learnt from")
    grid = ChartGrid(face_chart(head), config.size)
    total = len(learnt) + len(tested)

    def painted(people: Sequence[ActedTextures], stream: LookSeed, before: int) -> TexturePairs:
        looks = painted_people(people, grid, config, styles, (seed, stream), lambda n, _: report(before + n, total))
        return TexturePairs(looks, grid, config)

    with naming(textures.folder):
        own = painted(learnt, LookSeed.TRAINING, 0)
        pairs = painted(tested, LookSeed.EVALUATION, len(learnt))
    painters = {name: network_painter(model, grid) for name, model in models.items()}
    painters["linear"] = linear_painter(own, seed)
    painters["spline"] = spline_painter(grid, head.annotation.landmarks)
    takes = takes_of(tested[:TAKES], grid)
    return TextureTest(painters, train_reader(own, seed), pairs, takes)
