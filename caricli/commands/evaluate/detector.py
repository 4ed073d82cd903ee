"""caricli evaluate detector: what a detector finds, beside what is there."""

from typing import Any

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
)
from caricli.commands.shared.tables import detector_figures, number, print_table
from caricli.errors import shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SHOWN = 24
"""Pictures of each set on the sheet."""

TILE = 512
"""Pixels of one on the sheet, at most."""

_PARTS = ("jaw", "brows", "nose", "eyes", "mouth", "all")


@click.command()
@click.option(
    "--pictures", type=PATH, metavar="DIR", help="Measure on this folder of `caricli dataset pictures`, made of others."
)
@click.option("--real", type=PATH, metavar="DIR", help="Measure on these pictures, with landmarks of the same names.")
@click.option("--detector", type=PATH, metavar="FILE", help="Measure this detector.  [default: caricli's]")
@click.option("--count", type=WholeRange(1, 10**6), default=1000, metavar="N", help="Take N pictures at most.")
@out_option("DIR", "Write detector.json and detector.png into this folder.")
@pts_origin_option
@overwrite_option
def command(pictures, real, detector, count, out, pts_origin, overwrite):
    """Compare faces, landmarks and regions that a detector finds with the true ones.

    Landmark errors (NME) are mean distances in percent of the diagonal of a face's 68 landmarks, of the faces that are
    found; a face fails where it is not found or its error is above 8 %. Of a folder with people whom the detector has
    seen, only pictures of test people count. The mean shape is that of all true faces, laid into every one's frame.

    \b
    Example:
      caricli evaluate detector --pictures others --out figures
      caricli evaluate detector --real drawings --detector run/model.safetensors --out figures
    """
    from caricli.store.detector import load_detector
    from caricli.store.judged_pictures import judged_inputs, load_judged_sets

    if pictures is None and real is None:
        raise click.UsageError("Give pictures with --pictures, --real, or both.")
    if real is None:
        refuse_typed("--pts-origin is of the landmarks of --real.", "pts_origin")
    inputs = judged_inputs(pictures, real)
    with staged_folder(out, overwrite=overwrite, inputs=(*inputs, detector, real), marker="detector.json") as folder:
        own = load_detector(detector)
        sets, note = load_judged_sets(pictures, real, own, count, pts_origin)
        tallies, sheet = _evaluate(own, sets)
        figures = {name: tally.figures for name, tally in tallies.items()}
        write_json(folder / "detector.json", provenance("evaluate detector", [*inputs, detector]) | figures)
        write_png(folder / "detector.png", sheet)
    echo_notes(note)
    _print(figures)
    echo_result(f"{shown(out)}: {'; '.join(map(detector_figures, figures.values()))}")


def _evaluate(detector: Any, sets: dict) -> tuple[dict, Any]:
    """DetectorTallies of sets of pictures, and a sheet with some of them."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_detector import DetectorTally, evaluate_detector
    from caricli.render.sheets.contact_sheet import contact_sheet
    from caricli.render.sheets.detection_sheet import detection_sheet, smaller

    tallies = {name: DetectorTally() for name in sets}
    tiles = []
    labels = []
    for name, pictures in sets.items():
        with progress_bar(f"measuring {name} pictures") as report:
            for done, (judged, detection) in enumerate(evaluate_detector(detector, pictures), 1):
                tallies[name].add(judged, detection)
                if done <= SHOWN:
                    tiles.append(smaller(detection_sheet(judged.marked.pixels, detection), TILE))
                    labels.append(judged.name)
                report(done, len(pictures))
    return tallies, contact_sheet(tiles, None, labels)


def _print(figures: dict) -> None:
    """Print the figures of DetectorTallies by set."""
    for name, own in figures.items():
        rows = [("detector", *_cells(own["nme"])), ("mean shape", *_cells(own["mean_shape"]))]
        print_table(("NME %", *_PARTS), rows, f"{own['faces']} faces of {own['pictures']} {name} pictures")
        classes = {**own["media"], **{f"yaw {limits}": row for limits, row in own["yaws"].items()}}
        rows = [(kind, str(row["faces"]), str(row["found"]), number(row["nme"], 2)) for kind, row in classes.items()]
        print_table(("pictures", "faces", "found", "NME %"), rows)
        if own["iou"]:
            click.echo("IoU: " + ", ".join(f"{region} {value:.2f}" for region, value in own["iou"].items()))
        if own["within"]:
            shares = (100 * own["within"][axis] for axis in ("along", "across"))
            click.echo("errors within one spread: {:.0f} % along its longer axis, {:.0f} % across".format(*shares))


def _cells(nme: dict | None) -> list[str]:
    return [number((nme or {}).get(part), 2) for part in _PARTS]
