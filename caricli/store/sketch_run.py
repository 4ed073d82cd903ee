"""The training of a sketch network in its folder."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from caricli.data.dataset import Dataset, read_dataset
from caricli.data.unseen import seen_people
from caricli.methods.train.train_sketch import SketchTraining
from caricli.models.linear_model import LinearModel
from caricli.models.sketch.model import SketchModel, sketch_to_checkpoint
from caricli.store.models import check_topology
from caricli.store.sketch_networks import load_sketch_basis, load_sketch_network
from caricli.store.training_run import MODEL, RunFolder
from caricli.structures import SeenPeople


def load_sketch_ingredients(folders: Sequence[Path], basis: Path | None) -> tuple[list[Dataset], LinearModel]:
    """Datasets, and the linear model of their topology whose latents a network learns to tell.

    basis: file or kind of the model, or None for the bundled one.
    Raises InputError when one is missing, damaged or does not fit the others.
    """
    model = load_sketch_basis(basis)
    datasets = [read_dataset(folder) for folder in folders]
    for folder, data in zip(folders, datasets, strict=True):
        check_topology(model.template, data.template, folder)
    return datasets, model


def everybody(datasets: Sequence[Dataset]) -> SeenPeople:
    """Whom a training on datasets sees."""
    people = [seen_people(data) for data in datasets]
    parts = (
        frozenset().union(*(each.train for each in people)),
        frozenset().union(*(each.validation for each in people)),
    )
    return SeenPeople(*parts)


class SketchRun(RunFolder):
    """The folder of a sketch network's training."""

    curve = "shape error"
    axis = "mean distance of vertices in % of the head's height"

    def follow(self, training: SketchTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""
        curves = tuple(curve.name for curve in training.curves)

        def checkpoint() -> tuple[dict, dict]:
            network = training.copied_average()
            model = SketchModel(network, training.config.size, curves, training.model.model_id, self.recipe)
            return sketch_to_checkpoint(model)

        return self.record(training, training.model.template.height, checkpoint)

    def finish(self, training: SketchTraining) -> dict:
        """Write the report of the best model. Returns its figures."""
        network = load_sketch_network(self.folder / MODEL)
        percent = 100 * training.best / training.model.template.height
        figures = {"percent": percent, "millimetres": 1000 * training.best}
        self.report({"model_id": network.model_id, "validation": figures})
        return figures
