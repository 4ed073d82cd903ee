"""caricli evaluate blendshapes: how near the expressions of caricatures come to true ones, method by method."""

from dataclasses import replace

import click
import numpy as np

from caricli.commands.shared.options import PATH, data_option, out_option, overwrite_option, seed_option
from caricli.errors import CaricliError, InputError, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE = 224
SHOWN = ("laugh", "surprise", "closed_eyes", "pucker", "caricature_disdain", "caricature_furious")
_COLUMNS = {
    "error": ("error %", 3), "drift": ("drift %", 3), "strength": ("strength", 3), "excess": ("excess %", 1),
    "structure": ("structure", 3), "flipped": ("flips %", 3), "seconds": ("s", 2),
}  # fmt: skip


@click.command()
@data_option
@out_option("DIR", "A folder for blendshapes.json, every figure, and blendshapes.png.")
@click.option("--count", type=click.IntRange(1, 10_000), default=50, metavar="N", help="Caricatures to measure.")
@click.option("--everyone", is_flag=True, help="Not only test people: for a dataset that no model was trained on.")
@click.option("--given", type=click.Choice(["neutral", "any"]), default="neutral", help="What their pictures show.")
@click.option("--face", "faces", type=PATH, multiple=True, metavar="FACE.npz", help="Draw these, too; repeat.")
@seed_option
@overwrite_option
def command(dataset, out, count, everyone, given, faces, seed, overwrite):
    """Build the expressions of caricatures by every method, and compare them with the true ones.

    The dataset is a full grid, without --count, so that it has the same caricature with every expression. Each is seen
    once, in a random pose. Errors are mean distances to the true shapes in percent of the head's height. Drift is how
    far a caricature moves where the normal face hardly does, which changes who it is; strength, how far where that one
    moves clearly, as a share of its way; excess, how much farther on average; structure, how much the cosines between
    expressions differ from the normal face's. With --face the methods are drawn on real drawings, too.

    \b
    Example:
      caricli evaluate blendshapes --data grid --out expressions
      caricli evaluate blendshapes --data grid --everyone --given any --face drawing.npz --out expressions
    """
    from caricli.commands.blended import load_caricature, load_tools
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.methods.evaluate.evaluate_blendshapes import mean_comparison
    from caricli.render.contact_sheet import contact_sheet
    from caricli.store.datasets import dataset_files
    from caricli.store.models import DEFAULT_LATENT, check_topology, load_model

    inputs = [dataset, *dataset_files(dataset), *faces]
    with staged_folder(out, overwrite=overwrite, inputs=inputs, marker="blendshapes.json") as folder:
        data, tools, latent = read_dataset(dataset), load_tools(), load_model(kind=DEFAULT_LATENT)
        check_topology(tools.morphable.template, data.template, "the bundled morphable model")
        tools, caricatures = _known(data, tools, dataset, everyone, count)
        drawings = {path.stem: load_caricature(path, tools.morphable) for path in faces}
        generator, figures, cells = np.random.default_rng(seed), [], []
        with progress_bar("building blendshapes") as progress:
            for known in caricatures:
                # One is enough to see, the most exaggerated of somebody.
                draw = not cells and known.level == max(each.level for each in caricatures)
                found, drawn = _compared(known, given, generator, tools, latent, draw)
                figures.append(found)
                cells += drawn
                progress(len(figures), len(caricatures) + len(drawings))
            for name, face in drawings.items():
                cells += _drawn(name, face, tools)
        whole, errors, nearest, compared = mean_comparison(figures)
        rows = {
            name: {rival: values[k] for rival, values in errors.items() if np.isfinite(values[k])}
            | {"full_is_nearest_on": int(nearest[k]), "of": int(compared[k])}
            for k, name in enumerate(tools.expressions)
        }
        recipe = provenance("evaluate blendshapes", [dataset / "dataset.json", *faces], seed, given=given)
        labels, drawn = zip(*cells, strict=True)
        each = [
            {"person": known.identity, "level": known.level, "rivals": _finite(found, [*tools.expressions])}
            for known, found in zip(caricatures, figures, strict=True)
        ]
        write_json(folder / "blendshapes.json", recipe | {"means": whole, "expressions": rows, "caricatures": each})
        write_png(folder / "blendshapes.png", contact_sheet(drawn, 1 + len(SHOWN), labels))
    _print_tables(len(figures), whole, rows)


def _known(data, tools, where, everyone, count):
    """BlendTools for the expressions of a Dataset, and its KnownCaricatures, ``count`` of them at most."""
    from caricli.methods.evaluate.evaluate_blendshapes import dataset_expressions, known_caricatures
    from caricli.methods.rig.expression_templates import combined_templates

    try:
        expressions = dataset_expressions(data, tools.actions.names)
    except InputError as error:
        raise InputError(f"{shown(where)}: {error}") from error
    people = sorted(set(data.identity.tolist()) if everyone else data.manifest["splits"]["test"])
    found = known_caricatures(data, people)
    if not found:
        raise InputError(
            f"{shown(where)}: expected caricatures with every expression, found none; build one without --count"
        )
    # Of as many people as there are.
    chosen = np.unique(np.linspace(0, len(found) - 1, count).round().astype(int))
    own = replace(tools, expressions=expressions, templates=combined_templates(tools.actions, expressions))
    return own, [found[k] for k in chosen]


def _compared(known, given, generator, tools, latent, draw):
    """Figures of one KnownCaricature by rival, and its pictures with labels, if they are to be drawn."""
    from caricli.commands.blended import Caricature
    from caricli.methods.evaluate.evaluate_blendshapes import compare_blendshapes, random_pose

    shows = 0 if given == "neutral" else int(generator.integers(len(known.truth)))
    pose = random_pose(generator, np.ptp(known.truth[shows][:, 1]))
    use = tools.templates, tools.morphable, tools.landmark_map, latent
    try:
        rivals, made = compare_blendshapes(known.truth, shows, pose, *use)
    except CaricliError as error:
        raise type(error)(f"person {known.identity}, level {known.level}: {error}") from error
    if not draw:
        return rivals, []
    face = Caricature(known.truth[shows], pose, (None, None), [])
    return rivals, [cell for rival, shapes in made.items() for cell in _row(rival, face, shapes, tools)]


def _finite(rivals, names):
    """Figures by rival, those of expressions by name; what is not a number is left out."""
    return {
        rival: {
            key: {n: float(v) for n, v in zip(names, value, strict=True) if np.isfinite(v)} if np.ndim(value) else value
            for key, value in found.items()
        }
        for rival, found in rivals.items()
    }


def _drawn(name, face, tools):
    """Pictures of a real Caricature by every method, with labels."""
    from caricli.commands.blended import build
    from caricli.methods.expressions.build_blendshapes import METHODS

    rows = ((f"{name}: {method}", build(tools, face, method)) for method in METHODS)
    return [cell for label, made in rows for cell in _row(label, face, made, tools)]


def _row(label, face, made, tools):
    """The face as given and some of its expressions: pictures with labels."""
    from caricli.commands.blended import with_given
    from caricli.render.draw_rig import draw_rig, neutral_sky

    rig, *_ = tools.rig(made, np.random.default_rng(0), True, face.pictures)
    sky = neutral_sky(rig)
    shapes = [(label, with_given(rig, face))]
    for name in SHOWN:
        known = name in rig.names
        shapes.append((name, rig.neutral + (rig.deltas[rig.names.index(name)] if known else 0)))
    return [(label, draw_rig(rig, shape, "front", SIZE, sky)) for label, shape in shapes]


def _print_tables(count, whole, rows):
    from rich.console import Console
    from rich.table import Column, Table

    console = Console(width=None if Console().is_terminal else 120)
    table = Table(
        Column("method", no_wrap=True), *(title for title, _ in _COLUMNS.values()), title=f"{count} caricatures"
    )
    for name, row in whole.items():
        table.add_row(name, *(f"{row[key]:.{digits}f}" if key in row else "-" for key, (_, digits) in _COLUMNS.items()))
    console.print(table)
    rivals = [name for name in whole if name != "truth"]
    table = Table(Column("error % of", no_wrap=True), *rivals, "full nearest", title="expressions")
    for name, row in rows.items():
        if row["of"]:
            cells = (f"{row[rival]:.3f}" for rival in rivals)
            table.add_row(name, *cells, f"{row['full_is_nearest_on']} of {row['of']}")
    console.print(table)
