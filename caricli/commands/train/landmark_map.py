"""caricli train landmark-map: a map between the landmarks of normal faces and of caricatures."""

from dataclasses import asdict

import click
import numpy as np

from caricli.commands.shared.options import (
    config_option,
    data_option,
    out_option,
    overwrite_option,
    seed_option,
    set_option,
)
from caricli.errors import InputError, shown
from caricli.io.checkpoint import write_checkpoint
from caricli.io.config import read_config
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

HELD_OUT = 10
_FEWEST = 3
_SPLITS = ("training", "unseen", "test")


@click.command()
@data_option
@out_option("MAP.safetensors", "The map; MAP.json, its recipe and errors, is written beside it.", suffix=".safetensors")
@config_option
@set_option
@seed_option
@overwrite_option
def command(dataset, out, config, overrides, seed, overwrite):
    """Train a map between landmarks of normal faces and of caricatures, for `caricli map-landmarks`.

    Two small networks learn from faces of both domains, never from pairs of them. Faces of the test split measure them:
    where the dataset was generated, caricatures beside the regular faces that they were made of.

    \b
    Example:
      caricli train landmark-map --data dataset --out map.safetensors
      caricli train landmark-map --data dataset --out small.safetensors --set dimension=16 --seed 1
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.methods.train.train_landmark_map import train_landmark_map
    from caricli.models.config import LandmarkMapConfig
    from caricli.models.landmark_map.model import map_from_checkpoint, map_to_checkpoint
    from caricli.store.datasets import dataset_files

    settings = read_config(config, LandmarkMapConfig, overrides)
    report_file = out.with_suffix(".json")
    with staged(out, report_file, overwrite=overwrite, inputs=(dataset, config, *dataset_files(dataset))) as files:
        data = read_dataset(dataset)
        rows = _rows(data, dataset)
        with progress_bar("looking at faces") as report:
            faces = _look(data, rows, settings.views, seed, report)
        with progress_bar("training landmark-map") as report:
            trained, records = train_landmark_map(faces["training"], faces["unseen"], settings, seed, report)
        recipe = provenance("train landmark-map", [dataset / "dataset.json"], seed, config=asdict(settings))
        checkpoint = map_to_checkpoint(trained, recipe)
        write_checkpoint(files[0], *checkpoint)
        landmark_map = map_from_checkpoint(*checkpoint, shown(out))
        with progress_bar("measuring") as report:
            figures = _figures(landmark_map, data, rows, faces, settings.views, seed, report)
        write_json(files[1], recipe | figures | {"epochs": records})
    click.echo(f"{out}: {_summary(figures)}")


def _rows(data, where):
    """Rows for training, unseen and test by domain: of the people trained on every tenth is held out."""
    from caricli.methods.train.train_landmark_map import domain_rows

    people = np.array(data.manifest["splits"]["train"])
    held = np.isin(data.identity, people[HELD_OUT - 1 :: HELD_OUT]) | data.rows("validation")
    splits = {"training": data.rows("train") & ~held, "unseen": held, "test": data.rows("test")}
    domains = domain_rows(data)
    rows = {split: {n: np.flatnonzero(chosen & m) for n, m in domains.items()} for split, chosen in splits.items()}
    for name, found in rows["training"].items():
        if len(found) < _FEWEST:
            expected = f"at least {_FEWEST} training meshes of {name} faces"
            raise InputError(f"{shown(where)}: expected {expected}, found {len(found)}")
        # A small dataset is better judged by what it was trained on than by nothing.
        if len(rows["unseen"][name]) < _FEWEST:
            rows["unseen"][name] = found
    return rows


def _look(data, rows, views, seed, report):
    """SeenFaces by split and domain."""
    faces, parts = {split: {} for split in rows}, [(split, name) for split in rows for name in rows[split]]
    for done, (split, name) in enumerate(parts):
        report(done, len(parts))
        chosen = rows[split][name]
        faces[split][name] = _seen(data, data.vertices[chosen].astype(np.float64), chosen, split, name, views, seed)
    return faces


def _seen(data, vertices, rows, split, name, views, seed):
    """SeenFaces of meshes: the poses depend on nothing but seed, split and domain."""
    from caricli.methods.train.train_landmark_map import see_faces
    from caricli.models.landmark_map.model import DOMAINS

    generator = np.random.default_rng([seed, _SPLITS.index(split), DOMAINS.index(name)])
    kinds = int(data.expression.max()) + 1
    return see_faces(vertices, data.expression[rows], kinds, data.template, views, generator)


def _figures(landmark_map, data, rows, faces, views, seed, report):
    """What the JSON says of a map: cycle errors, and errors beside rivals where the true faces are known."""
    from caricli.methods.train.train_landmark_map import (
        cycle_errors,
        has_partners,
        measure_landmark_map,
        regular_faces,
    )

    test = {name: seen.points for name, seen in faces["test"].items() if len(seen.points)}
    figures = {"meshes": {split: {n: len(r) for n, r in own.items()} for split, own in rows.items()}}
    figures["cycle_error"] = cycle_errors(landmark_map, test)
    if not has_partners(data) or "caricature" not in test:
        return figures
    pairs = {}
    for done, split in enumerate(("training", "test")):
        report(done, 2)
        chosen = rows[split]["caricature"]
        regular = _seen(data, regular_faces(data, chosen), chosen, split, "caricature", views, seed)
        pairs[split] = {"normal": regular.points, "caricature": faces[split]["caricature"].points}
    return figures | {"error": measure_landmark_map(landmark_map, pairs["test"], pairs["training"])}


def _summary(figures):
    """One line."""
    cycles = ", ".join(f"{name} {error:.2f} %" for name, error in figures["cycle_error"].items())
    text = f"there and back {cycles}"
    if "error" in figures:
        error = figures["error"]["normal"]
        text = f"error to normal {error['map']:.2f} %, without a map {error['identity']:.2f} %; {text}"
    return f"{text} of the face's diagonal"
