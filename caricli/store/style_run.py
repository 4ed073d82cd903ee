"""The training of a style network in its folder."""

from collections.abc import Iterator, Sequence

import numpy as np

from caricli.methods.dynamic.media import NAMES
from caricli.methods.train.processes import Share
from caricli.methods.train.stages import Report, unwatched
from caricli.methods.train.texture.painted_pairs import painted_pairs
from caricli.methods.train.texture.train_style import StyleTraining, style_errors
from caricli.models.style.config import StyleConfig
from caricli.models.style.model import StyleModel, style_to_checkpoint
from caricli.seeds import TrainingSeed
from caricli.store.styles import load_style
from caricli.store.training_run import RunFolder
from caricli.template.head import load_head


def style_training(
    drawings: Sequence[np.ndarray], config: StyleConfig, share: Share, report: Report = unwatched
) -> StyleTraining:
    """A training on faces of the default head, and on styles of drawings (H, W, 3) uint8, too.

    share: of this process. report: called with faces that are drawn, and of how many.
    """
    template = load_head().template()
    total = config.pictures + config.validation
    pairs = painted_pairs(
        template, config.pictures, (config.seed, TrainingSeed.SURFACE), lambda done, count: report(done, total)
    )
    unseen = painted_pairs(
        template,
        config.validation,
        (config.seed, TrainingSeed.VALIDATION),
        lambda done, count: report(config.pictures + done, total),
    )
    return StyleTraining(pairs, unseen, drawings, config, share)


class StyleRun(RunFolder):
    """The folder of a style network's training."""

    curve = "error of style"
    axis = "mean difference of local colours and slopes in % of white"

    def follow(self, training: StyleTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""
        return self.record(
            training, 1.0, lambda: style_to_checkpoint(StyleModel(training.copied_average(), NAMES, self.recipe))
        )

    def finish(self, training: StyleTraining) -> dict:
        """Write the report of the best model. Returns its error on unseen faces, and that of faces left as they are."""
        model = self.best_model(load_style)
        errors = 100 * np.mean(style_errors(model, training.unseen), axis=0)
        figures = {"error": float(errors[0]), "kept": float(errors[1])}
        self.report({"model_id": model.model_id, "validation": figures})
        return figures
