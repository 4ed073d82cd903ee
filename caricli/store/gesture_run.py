"""The training of a gesture network in its folder."""

from collections.abc import Iterator

from caricli.methods.train.train_gesture import GestureTraining
from caricli.models.gesture.model import GestureModel, gesture_to_checkpoint
from caricli.store.gestures import load_gestures
from caricli.store.training_run import RunFolder


class GestureRun(RunFolder):
    """The folder of a gesture network's training."""

    curve = "doubt"
    axis = "mean chance of other gestures in %"

    def follow(self, training: GestureTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""
        return self.record(
            training, 1.0, lambda: gesture_to_checkpoint(GestureModel(training.copied_average(), self.recipe))
        )

    def finish(self, training: GestureTraining) -> dict:
        """Write the report of the best model. Returns the percentage of validation strokes that it tells right."""
        model = self.best_model(load_gestures)
        right = total = 0
        for name, strokes in training.unseen.items():
            right += sum(model.recognise(stroke).likeliest == name for stroke in strokes)
            total += len(strokes)
        figures = {"right": 100 * right / total}
        self.report({"model_id": model.model_id, "validation": figures})
        return figures
