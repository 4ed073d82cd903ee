"""caricli train deformable: the SIREN hypernetwork."""

import copy
import json
import os
import time
from contextlib import contextmanager
from dataclasses import asdict

import click

from caricli.commands.shared.options import (
    PATH,
    config_option,
    data_option,
    device_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.errors import InputError, OutputError
from caricli.io.checkpoint import write_checkpoint
from caricli.io.config import read_config
from caricli.io.image import write_png
from caricli.io.outputs import staged, write_bytes
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.io.training_state import read_state, write_state

FILES = ("state.pt", "model.safetensors", "model.json", "log.jsonl", "loss.png")


@click.command()
@data_option
@out_option("RUN_DIR", "A folder for model, log, loss curve and the state to resume from.")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@device_option
@click.option(
    "--template", type=PATH, metavar="OBJ", help="The shape to deform, no two parts touching.  [default: lips apart]"
)
@overwrite_option
def command(dataset, out, config, overrides, resume, device, template, overwrite):
    """Train a SIREN that deforms the template, its weights made from a latent by a hypernetwork.

    The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json. Killed at
    any moment, the same command with --resume ends in the same model. Under torchrun every process takes its share of
    each batch.

    \b
    Example:
      caricli train deformable --data dataset --out run
      caricli train deformable --data dataset --out run --resume
      caricli train deformable --data dataset --out paper --config configs/deformable/paper.yaml --device cuda
    """
    from caricli.data.dataset import read_dataset
    from caricli.models.config import DeformableConfig

    settings = read_config(config, DeformableConfig, overrides)
    with _processes(device) as (device, process, processes):
        data = read_dataset(dataset)
        recipe = provenance("train deformable", [dataset / "dataset.json", template], config=asdict(settings))
        run = _Run(out, recipe, device, resume, overwrite, writes=process == 0)
        training = _training(data, settings, network_points(data.template, template), device, process, processes)
        run.follow(training, data)
        if process == 0:
            run.finish(data)


class _Run:
    """The folder of a training."""

    def __init__(self, folder, recipe, device, resume, overwrite, writes):
        self.folder, self.recipe, self.writes, self.state = folder, recipe, writes, None
        self.log, self.seconds, self.started = [], 0.0, time.monotonic()
        state = folder / "state.pt"
        if resume and state.exists():
            self.state, trained = read_state(state, device)
            if _essence(trained) != _essence(recipe):
                raise InputError(
                    f"{state}: expected a training with these settings and data, found another "
                    f"({_difference(trained, recipe)}); --overwrite begins anew"
                )
            self.log, self.seconds = self.state["log"], self.state["seconds"]
        elif writes:
            self._prepare(overwrite or resume)

    def _prepare(self, overwrite):
        if self.folder.exists() and not self.folder.is_dir():
            raise OutputError(f"{self.folder}: expected a folder to write, found a file")
        old = [self.folder / name for name in FILES if (self.folder / name).exists()]
        if old and not overwrite:
            raise OutputError(f"{old[0]} exists; give --resume to go on or --overwrite to begin anew")
        for path in old:
            path.unlink()

    def follow(self, training, data):
        """Train to the end; log, checkpoint and keep the best model on the way."""
        config, height = training.config, data.template.height
        if self.state is not None:
            training.load_state(self.state)
        last = time.monotonic()
        with _training_bar(config.epochs) as show:
            for record in training.epochs():
                percent = {
                    name: None if error is None else 100 * error / height
                    for name, error in (("train", record.train_error), ("validation", record.validation_error))
                }
                self.log.append({"epoch": record.epoch, "loss": record.loss, **percent, "seconds": self._elapsed()})
                show(self.log[-1])
                if not self.writes:
                    continue
                if record.best:
                    self._write_model(training, data.template)
                if training.ended or time.monotonic() - last >= config.checkpoint_seconds:
                    self._write_state(training)
                    last = time.monotonic()

    def finish(self, data):
        """Measure the best model and write what is known about it."""
        from caricli.methods.evaluate.evaluate_shape import evaluate_shape, spread_rows
        from caricli.store.models import load_model

        model = load_model(self.folder / "model.safetensors")
        errors = {}
        for split in ("validation", "test"):
            error = evaluate_shape(model, data.vertices[spread_rows(data.rows(split), 100)])
            errors |= {} if error is None else {split: asdict(error)}
        best = [line for line in self.log if line["validation"] is not None]
        more = {"model_id": model.model_id, "epochs": self.log[-1]["epoch"], "shape_error": errors}
        with staged(self.folder / "model.json", overwrite=True) as (temporary,):
            write_json(temporary, self.recipe | more | {"log": best[-20:]})
        figures = ", ".join(f"{split} {error['percent']:.3f} %" for split, error in errors.items())
        click.echo(f"{self.folder / 'model.safetensors'}: shape error {figures} of the head's height")

    def _elapsed(self):
        return round(self.seconds + time.monotonic() - self.started, 1)

    def _write_model(self, training, template):
        from caricli.models.checkpoint import model_to_checkpoint

        with staged(self.folder / "model.safetensors", overwrite=True) as (temporary,):
            write_checkpoint(temporary, *model_to_checkpoint(_model(training, template), self.recipe))

    def _write_state(self, training):
        state = training.state() | {"log": self.log, "seconds": self._elapsed()}
        write_state(self.folder / "state.pt", state, self.recipe)
        with staged(self.folder / "log.jsonl", overwrite=True) as (temporary,):
            write_bytes(temporary, "".join(json.dumps(line) + "\n" for line in self.log).encode())
        if training.ended or self.log[-1]["validation"] is not None:
            self._write_plot()

    def _write_plot(self):
        from caricli.render.plot_curves import plot_curves

        known = {name: [line for line in self.log if line[name] is not None] for name in ("train", "validation")}
        curves = {name: ([r["epoch"] for r in rows], [r[name] for r in rows]) for name, rows in known.items()}
        with staged(self.folder / "loss.png", overwrite=True) as (temporary,):
            write_png(temporary, plot_curves({"shape error": curves}))


def _essence(recipe):
    """What must be the same for a training to go on: settings and contents, not where the files lie."""
    return recipe["config"], sorted(recipe["inputs"].values())


def _difference(trained, asked):
    """What is not the same, in words."""
    then, now = trained["config"], asked["config"]
    settings = [f"{name} {then.get(name)} there, {now[name]} here" for name in now if then.get(name) != now[name]]
    return ", ".join(settings) or "other data"


def _training(data, config, points, device, process, processes):
    import torch

    from caricli.methods.train.train_autodecoder import AutoDecoderTraining, Surface
    from caricli.models.deformable.model import Frame, HyperSiren

    shapes, unseen = (data.vertices[data.rows(split)] for split in ("train", "validation"))
    if len(shapes) < 3:
        raise InputError(f"the dataset's training split has {len(shapes)} meshes, at least 3 are needed")
    generator = torch.Generator().manual_seed(config.seed)
    network = HyperSiren(config.size(), generator, getattr(torch, config.precision)).to(device)
    surface = Surface(Frame(points), data.template.faces, device)
    return AutoDecoderTraining(network, surface, shapes, unseen, config, process, processes)


def _model(training, template):
    from caricli.models.deformable.model import DeformableModel
    from caricli.models.prior import Prior

    latents = training.latents.detach().cpu().double().numpy()
    # A copy: the model freezes its weights.
    network = copy.deepcopy(training.network)
    return DeformableModel(template, network, training.surface.frame.points, Prior.of(latents))


def network_points(template, path=None):
    """(V, 3) the shape that the network deforms: of a file, the open head with its lips apart, or the template."""
    import numpy as np
    from scipy.spatial import cKDTree

    from caricli.io.face import read_face
    from caricli.template.head import load_head

    if path is not None:
        face = read_face(path)
        if face.mesh.topology_id != template.topology_id:
            raise InputError(f"{path}: its topology is not the dataset's ({len(template.vertices)} vertices)")
        points = face.vertices
    elif template.topology_id == load_head().template().topology_id:
        points = load_head().open_mouth_template().vertices
    else:
        points = template.vertices
    nearest = cKDTree(points).query(points, 2)[0][:, 1]
    touching = int(np.sum(nearest < 1e-6 * template.height))
    if touching:
        note = f"caricli: {touching} vertices lie on others, which the network cannot tell apart; see --template"
        click.echo(note, err=True)
    return points


def chosen_device(device):
    """The name for PyTorch of what --device asks for: auto, cpu or cuda."""
    import torch

    if device == "cuda" and not torch.cuda.is_available():
        raise InputError("--device cuda: this machine has no CUDA device that PyTorch can use")
    return ("cuda" if torch.cuda.is_available() else "cpu") if device == "auto" else device


@contextmanager
def _processes(device):
    """Yield (device, number of this process, count of processes); several only under torchrun."""
    import torch

    device = chosen_device(device)
    process, processes = (int(os.environ.get(name, default)) for name, default in (("RANK", 0), ("WORLD_SIZE", 1)))
    if device == "cuda":
        os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # what deterministic sums need
        torch.cuda.set_device(int(os.environ.get("LOCAL_RANK", 0)))
    torch.use_deterministic_algorithms(True)
    if processes > 1:
        torch.distributed.init_process_group("nccl" if device == "cuda" else "gloo")
    try:
        yield device, process, processes
    finally:
        torch.use_deterministic_algorithms(False)
        if processes > 1:
            torch.distributed.destroy_process_group()


@contextmanager
def _training_bar(epochs):
    """Yield show(line of the log): a bar with loss and errors where stderr is a terminal, else lines now and then."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("", total=epochs)
        validation = ""

        def show(line):
            nonlocal validation
            if line["validation"] is not None:
                validation = f", validation {line['validation']:.3f} %"
            text = f"loss {line['loss']:.4g}, train {line['train']:.3f} %{validation}"
            progress.update(task, completed=line["epoch"], description=text)
            if line["validation"] is not None and not console.is_terminal:
                minutes = line["seconds"] / 60 * (epochs / line["epoch"] - 1)
                click.echo(f"epoch {line['epoch']} of {epochs}: {text}, about {minutes:.0f} min left", err=True)

        yield show
