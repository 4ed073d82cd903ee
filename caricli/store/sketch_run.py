"""The training of a sketch network in its folder."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from caricli.data.dataset import Dataset, read_dataset
from caricli.methods.train.processes import Share
from caricli.methods.train.sketch.train_published import PublishedTraining
from caricli.methods.train.sketch.train_sketch import SketchTraining
from caricli.methods.train.stages import Report
from caricli.models.bilinear.model import BilinearModel
from caricli.models.linear_model import LinearModel
from caricli.models.sketch.config import SketchConfig
from caricli.models.sketch.model import SketchModel, sketch_to_checkpoint
from caricli.store.models import check_topology
from caricli.store.sketch_networks import load_bilinear, load_sketch_basis, load_sketch_network
from caricli.store.training_run import RunFolder


def load_sketch_ingredients(
    folders: Sequence[Path], basis: Path | None, config: SketchConfig
) -> tuple[list[Dataset], LinearModel | BilinearModel]:
    """Datasets, and the model of their topology whose latents a network learns to tell: linear, or bilinear where the
    network is a published one.

    basis: file or kind of the model, or None for the bundled one.
    Raises InputError when one is missing, damaged or does not fit the others.
    """
    model = load_bilinear(basis) if config.published else load_sketch_basis(basis)
    datasets = [read_dataset(folder) for folder in folders]
    for folder, data in zip(folders, datasets, strict=True):
        check_topology(model.template, data.template, folder)
    return datasets, model


def sketch_training(
    datasets: Sequence[Dataset], model: LinearModel | BilinearModel, config: SketchConfig, share: Share, report: Report
) -> SketchTraining | PublishedTraining:
    """The training of what the settings ask for; the rest as in either."""
    if isinstance(model, BilinearModel):
        return PublishedTraining(datasets, model, config, share, report)
    return SketchTraining(datasets, model, config, share)


class SketchRun(RunFolder):
    """The folder of a sketch network's training."""

    curve = "shape error"
    axis = "mean distance of vertices in % of the head's height"

    def follow(self, training: SketchTraining | PublishedTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""
        curves = tuple(curve.name for curve in training.curves)

        def checkpoint() -> tuple[dict, dict]:
            network = training.copied_average()
            model = SketchModel(network, training.config.size, curves, training.model.model_id, self.recipe)
            return sketch_to_checkpoint(model)

        return self.record(training, training.model.template.height, checkpoint)

    def finish(self, training: SketchTraining | PublishedTraining) -> dict:
        """Write the report of the best model. Returns its figures."""
        network = self.best_model(load_sketch_network)
        percent = 100 * training.best / training.model.template.height
        figures = {"percent": percent, "millimetres": 1000 * training.best}
        self.report({"model_id": network.model_id, "validation": figures})
        return figures
