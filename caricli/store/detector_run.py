"""The training of a detector in its folder."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from caricli.cores import usable_cores
from caricli.data.evenly import evenly
from caricli.data.picture_set import read_picture_set
from caricli.data.worker_pool import worker_pool
from caricli.errors import naming
from caricli.methods.evaluate.evaluate_detector import DetectorTally, JudgedPicture, evaluate_detector
from caricli.methods.train.detector.fit_jaw_places import fit_jaw_places
from caricli.methods.train.detector.fit_region_shift import fit_region_shift
from caricli.methods.train.detector.split_pictures import JoinedPictures, SplitPictures, marked_by_people
from caricli.methods.train.detector.train_detector import DetectorTraining
from caricli.methods.train.detector.window_batch import WindowSource
from caricli.methods.train.processes import Share
from caricli.methods.train.stages import Report, unwatched
from caricli.models.detector.calibration import TRUST, Calibration
from caricli.models.detector.config import DetectorConfig
from caricli.models.detector.model import detector_to_checkpoint
from caricli.models.detector.networks import detector_of, network_of
from caricli.store.detector import load_detector
from caricli.store.training_run import RunFolder


def load_training(
    folders: Sequence[Path], config: DetectorConfig, share: Share, device: str, start: Path | None
) -> DetectorTraining:
    """A training on folders of pictures, together.

    share: of this process. device: "cpu" or "cuda". start: file of the detector with whose weights it begins, or None
    for random ones.
    Raises InputError when it is no such folder or file.
    """
    training, unseen = (_joined(folders, split) for split in ("train", "validation"))
    with naming(", ".join(map(str, folders))):
        run = DetectorTraining(training, unseen, config, share, device)
    if start is not None:
        with naming(start):
            run.start_from(network_of(load_detector(start)))
    return run


@contextmanager
def drawing_ahead(training: DetectorTraining, folders: Sequence[Path]) -> Iterator[None]:
    """Let a process for every core but two draw what a GPU learns from; a CPU draws beside what it learns.

    folders: of the training's pictures.
    """
    cores = usable_cores()
    if training.device == "cpu" or cores < 3:
        yield
        return
    # Each reads what is true of the pictures itself: handed over to one after the other, they would start in a minute.
    with worker_pool(cores - 2, partial(_window_source, folders, training.config, training.share)) as run:
        training.draw_ahead(run)
        yield


def _window_source(folders: Sequence[Path], config: DetectorConfig, share: Share) -> WindowSource:
    return WindowSource(_joined(folders, "train"), config, share)


def _joined(folders: Sequence[Path], split: str) -> JoinedPictures:
    """Pictures of one split of all folders."""
    parts = []
    for folder in folders:
        pictures = read_picture_set(folder)
        with naming(folder):
            parts.append(SplitPictures(pictures, split))
    return JoinedPictures(parts)


class DetectorRun(RunFolder):
    """The folder of a detector's training."""

    curve = "landmark error"
    axis = "mean distance in % of the face's diagonal (validation) or the window's side (train)"

    def follow(self, training: DetectorTraining) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way. Yields the log's line of each epoch."""

        def checkpoint() -> tuple[dict, dict]:
            average = training.copied_average()
            return detector_to_checkpoint(detector_of(average, training.config.size, recipe=self.recipe))

        return self.record(training, 1.0, checkpoint)

    def finish(self, training: DetectorTraining, progress: Report = unwatched) -> dict:
        """Let the best model tell where jaws are marked and where its regions lie, measure it on the pictures that it
        was validated with, and let its doubts agree with its errors.

        progress: called with the pictures that are measured, and of how many. Returns the figures.
        """
        detector = self.best_model(load_detector)
        count = training.config.validation
        # Without the trust that an end that was stopped has written.
        detector.calibration = Calibration(
            jaw=fit_jaw_places(training.training.landmarks()),
            shift=fit_region_shift(detector, training.unseen, count),
        )
        tally = DetectorTally()
        numbers = evenly(training.unseen.numbers, count)
        pictures = (
            JudgedPicture(marked_by_people(training.unseen.marked(number)), str(number), "any") for number in numbers
        )
        for done, (judged, detection) in enumerate(evaluate_detector(detector, pictures), 1):
            tally.add(judged, detection)
            progress(done, len(numbers))
        trust = min(max(tally.trust, TRUST[0]), TRUST[1])
        detector.calibration = replace(detector.calibration, trust=trust)
        self.write_model(detector_to_checkpoint(detector))
        figures = tally.trusting(trust).figures
        self.report(
            {"model_id": detector.model_id, "trust": trust, "shift": detector.calibration.shift, "validation": figures}
        )
        return figures
