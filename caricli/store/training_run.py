"""The folder of a training: model, log, loss curve, and the state to resume from."""

import json
import math
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from caricli.data.dataset import Dataset
from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.image import write_png
from caricli.io.outputs import check_outputs, staged, staging_folders, write_bytes, writing
from caricli.io.strict_json import format_json, take, write_json
from caricli.io.training_state import read_state, write_state
from caricli.methods.evaluate.evaluate_shape import ShapeError, evaluate_splits
from caricli.methods.train.deformable.train_deformable import trained_model
from caricli.methods.train.stages import EpochRecord, Report, unwatched
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.checkpoint import model_to_checkpoint
from caricli.render.sheets.plot_curves import plot_curves
from caricli.store.models import load_model
from caricli.template.template import Template

STATE = "state.pt"
MODEL = "model.safetensors"
REPORT = "model.json"
LOG = "log.jsonl"
CURVES = "loss.png"
FILES = (REPORT, STATE, MODEL, LOG, CURVES)
"""In the order in which old ones go: stopped between any two, ``--resume`` still knows what to do."""

MEASURED = 100
"""Meshes of a split that the finished model is measured on, at most: encoding takes a second each."""

LOGGED = 20
"""Validations that the report repeats."""


Model = TypeVar("Model")


@dataclass(frozen=True)
class Beginning:
    """How a training treats a folder that holds one already.

    resume: go on from its state; begin where there is none. overwrite: begin anew. writes: whether this process is the
    one that writes. inputs: files and folders that the training reads, to none of which it may write (None entries are
    skipped).
    """

    resume: bool = False
    overwrite: bool = False
    writes: bool = True
    inputs: tuple[Path | None, ...] = ()


class Training(Protocol):
    """A training that can stop after any epoch and go on from its state as if it had not."""

    @property
    def config(self) -> Any:
        """Settings, ``checkpoint_seconds`` among them."""

    @property
    def ended(self) -> bool:
        """Whether nothing is left to do."""

    def state(self) -> dict:
        """Everything that the rest of the training depends on, for torch.save."""

    def load_state(self, state: dict) -> None:
        """Go on from a state that ``state()`` gave. Raises InputError when it is of another training."""

    def epochs(self) -> Iterator[EpochRecord]:
        """Train, and yield what came of it after every epoch."""


class RunFolder:
    """The folder of one training of any kind, from the beginning or from where it was left."""

    curve = "shape error"
    axis = "mean distance in % of the head's height"
    """What the learning curve is called, and its errors are."""

    def __init__(self, folder: Path, recipe: dict, beginning: Beginning) -> None:
        """Read the state to go on from. Files of an older training stay until the first epoch of the new one is done.

        recipe: JSON object, how it is trained.
        Raises InputError when there is a training or a model with other settings or data, OutputError when files are in
        the way or an input would be written to.
        """
        self.folder = folder
        self.recipe = recipe
        self.writes = beginning.writes
        self.state: dict | None = None
        self.log: list[dict] = []
        self.seconds = 0.0
        self.started = time.monotonic()
        self.leftovers: list[Path] = []
        """Of trainings that were killed while they wrote; but one may write still, so they go when this one is done."""
        self.logged: bytes | None = None
        """The log as this process last saw or wrote it: another one is of a training that writes here, too."""
        if self.writes:
            self._check_folder(beginning.inputs)
            self.logged = self._log_there()
            self.leftovers = staging_folders(folder, FILES)
        path = folder / STATE
        if beginning.resume and path.exists():
            with _anew():
                self.state = self._read_state(path)
            self.log = self.state["log"]
            self.seconds = self.state["seconds"]
            if any(line["validation"] is not None for line in self.log):
                self.best_model(read_checkpoint)
        elif self.writes:
            self._check_old(beginning)

    def record(self, training: Training, unit: float, checkpoint: Callable[[], tuple[dict, dict]]) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way.

        unit: length that the training's errors are given in percent of. checkpoint: tensors and metadata of the model
        that it has come to. Yields the log's line of every epoch.
        Raises OutputError when another training writes into the folder.
        """
        if self.state is not None:
            with _anew(), naming(self.folder / STATE):
                training.load_state(self.state)
            if self.writes and training.ended:  # it may have been killed between its last state and its log
                self._write_log()
                self._write_curves()
        last = time.monotonic()
        for record in training.epochs():
            begins = not self.log
            self.log.append(self._line(record, unit))
            if self.writes and begins:
                self._remove_old()
                self._write_log()  # says of the first model that its training has not ended
            if self.writes and record.best:
                self.write_model(checkpoint())
            if self.writes and (training.ended or time.monotonic() - last >= training.config.checkpoint_seconds):
                self._write_state(training)
                last = time.monotonic()
            yield self.log[-1]

    def report(self, figures: dict) -> None:
        """Write the recipe with figures of the finished model, how long it took, and the end of the log."""
        about = {
            "epochs": self.log[-1]["epoch"],
            "seconds": self._elapsed(),
            "log": [line for line in self.log if line["validation"] is not None][-LOGGED:],
        }
        with self._writing(REPORT) as temporary:
            write_json(temporary, self.recipe | figures | about)
        for path in self.leftovers:
            shutil.rmtree(path, ignore_errors=True)

    def write_model(self, checkpoint: tuple[dict, dict]) -> None:
        """Write a model: tensors and metadata."""
        with self._writing(MODEL) as temporary:
            write_checkpoint(temporary, *checkpoint)

    def best_model(self, load: Callable[[Path], Model]) -> Model:
        """The best model so far. load: reads its file. Raises InputError when it is missing, damaged or of another
        training."""
        path = self.folder / MODEL
        with _anew():
            metadata = read_checkpoint(path)[1]
            with naming(path):
                _check_same(take(metadata, "recipe", dict), json.loads(format_json(self.recipe, path)))
            return load(path)

    def _read_state(self, path: Path) -> dict:
        """The state to go on from, which must be of this training."""
        state, trained = read_state(path)
        with naming(path):
            _check_same(trained, self.recipe)
            _check_log(state.get("log"), state.get("seconds"))
        return state

    def _check_folder(self, inputs: Sequence[Path | None]) -> None:
        if self.folder.exists() and not self.folder.is_dir():
            raise OutputError(f"{self.folder}: expected a folder to write, found a file")
        place = os.path.realpath(self.folder)
        if any(path is not None and os.path.realpath(path) == place for path in inputs):
            raise OutputError(f"{self.folder}: expected a folder to write, found one of the inputs")
        check_outputs(*(self.folder / name for name in FILES), overwrite=True, inputs=inputs)

    def _old(self) -> list[Path]:
        return [path for path in (self.folder / name for name in FILES) if path.exists() or path.is_symlink()]

    def _check_old(self, beginning: Beginning) -> None:
        """Refuse to replace anything but what a training leaves that was stopped before its first state."""
        old = self._old()
        if beginning.overwrite or not old:
            return
        if not beginning.resume:
            raise OutputError(f"{old[0]} exists; give --resume to go on or --overwrite to begin anew")
        left = {path.name for path in old}
        if REPORT in left or (MODEL in left and LOG not in left):
            raise OutputError(
                f"{old[0]}: expected {STATE} beside it to go on from, found none; --overwrite begins anew"
            )

    def _remove_old(self) -> None:
        self._require_alone()
        for path in self._old():
            path.unlink()
        self.logged = None

    def _log_there(self) -> bytes | None:
        path = self.folder / LOG
        with writing(path), suppress(FileNotFoundError):
            return path.read_bytes()
        return None

    def _require_alone(self) -> None:
        log = self._log_there()
        if log != self.logged:
            other = "no log" if log is None else "the log of another"
            raise OutputError(f"{self.folder}: expected to be the only training in this folder, found {other}")

    @contextmanager
    def _writing(self, name: str) -> Iterator[Path]:
        """A temporary path of a file, which takes its place unless another training writes into the folder."""
        with staged(self.folder / name, overwrite=True) as (temporary,):
            yield temporary
            self._require_alone()

    def _line(self, record: EpochRecord, unit: float) -> dict:
        return {
            "epoch": record.epoch,
            "loss": record.loss,
            "train": 100 * record.train_error / unit,
            "validation": None if record.validation_error is None else 100 * record.validation_error / unit,
        }

    def _elapsed(self) -> float:
        return round(self.seconds + time.monotonic() - self.started, 1)

    def _write_state(self, training: Training) -> None:
        state = training.state() | {"log": self.log, "seconds": self._elapsed()}
        self._require_alone()
        write_state(self.folder / STATE, state, self.recipe)
        self._write_log()
        if training.ended or self.log[-1]["validation"] is not None:
            self._write_curves()

    def _write_log(self) -> None:
        log = "".join(json.dumps(line) + "\n" for line in self.log).encode()
        with self._writing(LOG) as temporary:
            write_bytes(temporary, log)
        self.logged = log

    def _write_curves(self) -> None:
        lines = {name: [line for line in self.log if line[name] is not None] for name in ("train", "validation")}
        curves = {name: ([r["epoch"] for r in rows], [r[name] for r in rows]) for name, rows in lines.items()}
        with self._writing(CURVES) as temporary:
            write_png(temporary, plot_curves({self.curve: curves}, y_label=self.axis))


class TrainingRun(RunFolder):
    """The training of a shape model in its folder."""

    def follow(self, training: AutoDecoderTraining, template: Template) -> Iterator[dict]:
        """Train to the end; log, checkpoint and keep the best model on the way.

        template: of the model. Yields the log's line of every epoch: errors in percent of the template's height.
        """
        return self.record(
            training,
            template.height,
            lambda: model_to_checkpoint(trained_model(training, template), self.recipe),
        )

    def finish(self, data: Dataset, progress: Report = unwatched) -> dict[str, ShapeError]:
        """Measure the best model on meshes that it was not trained on, and write the report.

        progress: called with the meshes that are measured, and of how many.
        """
        model = self.best_model(load_model)
        errors = evaluate_splits(model, data, ("validation", "test"), MEASURED, progress)
        shape_error = {split: asdict(error) for split, error in errors.items()}
        self.report({"model_id": model.model_id, "shape_error": shape_error})
        return errors


@contextmanager
def _anew() -> Iterator[None]:
    """Let the message of an InputError raised inside say how to begin anew."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{error}; --overwrite begins anew") from error


def _check_same(trained: dict, asked: dict) -> None:
    """Refuse to go on with other settings, or other contents or the same in another order, which says what each is for;
    where the files lie does not matter."""
    then = trained.get("config")
    now = asked["config"]
    inputs = trained.get("inputs")
    hashes: list = list(inputs.values()) if isinstance(inputs, dict) else [None]
    others = list(asked["inputs"].values())
    if not isinstance(then, dict) or not all(isinstance(value, str) for value in hashes):
        raise InputError("expected a training with its settings and inputs, found none")
    commands = [recipe.get("command") for recipe in (asked, trained)]
    if commands[0] != commands[1]:
        expected, there = (f"`caricli {shown(command, 60)}`" for command in commands)
        raise InputError(f"expected a training by {expected}, found one by {there}")
    if then == now and hashes == others:
        return
    data = "the same data in another order" if sorted(hashes) == sorted(others) else "other data"
    settings = [f"{name} {then.get(name)} there, {now[name]} here" for name in now if then.get(name) != now[name]]
    raise InputError(f"expected a training with these settings and data, found another ({', '.join(settings) or data})")


def _check_log(log: Any, seconds: Any) -> None:
    """Refuse what is no list of lines as ``TrainingRun`` logs them, or no number of seconds."""
    numbers = ("epoch", "loss", "train")
    lines = log if isinstance(log, list) and log else [None]
    sound = all(
        isinstance(line, dict)
        and line.keys() == {*numbers, "validation"}
        and all(_is_number(line[name]) for name in numbers)
        and (line["validation"] is None or _is_number(line["validation"]))
        for line in lines
    )
    if not sound or not _is_number(seconds):
        raise InputError("expected a training with a log of its epochs, found none")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
