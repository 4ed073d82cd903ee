"""The training of a stroke network in its folder."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from caricli.data.dataset import Dataset, read_dataset
from caricli.methods.train.strokes.train_strokes import StrokesTraining
from caricli.models.strokes.model import StrokeModel, strokes_to_checkpoint
from caricli.store.models import check_topology
from caricli.store.strokes import load_strokes
from caricli.store.training_run import RunFolder


def load_people(folders: Sequence[Path]) -> list[Dataset]:
    """Datasets of one topology. Raises InputError when one is missing, damaged or of another one than the first."""
    datasets = [read_dataset(folder) for folder in folders]
    for folder, data in zip(folders, datasets, strict=True):
        check_topology(datasets[0].template, data.template, folder)
    return datasets


class StrokesRun(RunFolder):
    """The folder of a stroke network's training."""

    curve = "misread"
    axis = "places along strokes that are taken for something else in %"

    def follow(self, training: StrokesTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""

        def checkpoint() -> tuple[dict, dict]:
            network = training.copied_average()
            return strokes_to_checkpoint(StrokeModel(network, training.config.size, training.curves, self.recipe))

        return self.record(training, 1.0, checkpoint)

    def finish(self, training: StrokesTraining) -> dict:
        """Write the report of the best model. Returns its figures."""
        model = self.best_model(load_strokes)
        figures = {"misread": 100 * training.best}
        self.report({"model_id": model.model_id, "validation": figures})
        return figures
