"""The training of a texture network in its folder."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from caricli.data.texture_set import MANIFEST, ActedTextures, read_texture_set
from caricli.errors import naming
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.styles import StyleBook
from caricli.methods.train.stages import Report
from caricli.methods.train.texture_pairs import TexturePairs, painted_people
from caricli.methods.train.train_autodecoder import Share
from caricli.methods.train.train_texture import TextureTraining
from caricli.models.texture.config import TextureConfig
from caricli.models.texture.model import TextureModel, texture_to_checkpoint
from caricli.store.texture_networks import load_texture_network
from caricli.store.training_run import MODEL, RunFolder
from caricli.template.chart import face_chart
from caricli.template.head import load_head


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


def texture_sources(folders: Sequence[Path], drawings: Path | None) -> list[Path]:
    """Files that say what is in folders of textures."""
    return [folder / MANIFEST for folder in (*folders, *([] if drawings is None else [drawings]))]


def load_texture_ingredients(
    folders: Sequence[Path],
    drawings: Path | None,
    config: TextureConfig,
    styles: StyleBook,
    report: Report,
) -> TextureIngredients:
    """People of folders of textures, painted in styles.

    drawings: folder of textures for the unpaired part, or None. styles: StyleBook. report: called with people done and
    all. Raises InputError when a folder is none, damaged, of another topology than the others, or without people to
    train or to validate with.
    """
    sets = [read_texture_set(folder) for folder in folders]
    grid = ChartGrid(face_chart(load_head().template()), config.size)
    own, unseen = (
        [person for textures in sets for person in textures.people(split)] for split in ("train", "validation")
    )
    other = [] if drawings is None else list(read_texture_set(drawings).people("train"))
    total = len(own) + len(unseen) + len(other)
    done = 0

    def painted(people: Sequence[ActedTextures]) -> TexturePairs:
        nonlocal done
        before = done
        done += len(people)
        looks = painted_people(people, grid, config, styles, lambda count, _: report(before + count, total))
        return TexturePairs(looks, grid, config)

    with naming(", ".join(map(str, folders))):
        pairs = painted(own)
        unpaired = None if drawings is None else painted(other)
        return TextureIngredients(pairs, painted(unseen), unpaired)


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
        model = load_texture_network(self.folder / MODEL)
        figures = {"percent_of_kept": 100 * training.best}
        self.report({"model_id": model.model_id, "validation": figures})
        return figures
