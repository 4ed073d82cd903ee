"""caricli evaluate portrait: coarse and refined faces of portraits side by side."""

import click
import numpy as np

from caricli.commands.shared.options import PATH, FiniteRange, data_option, out_option, overwrite_option, seed_option
from caricli.errors import CaricliError, InputError, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE, TEXTURE, VIEW, SHOWN = 512, 512, 320, 6
MARKS = (".json", ".txt", ".pts", ".npy")
_PARTS = {"eyes": "eyes", "nose": "nose", "brows": "brow", "mouth": "mouth", "jaw": "contour", "all": "NME %"}
_REST = ("sum px", "colour %", "3D %", "flips %", "s")
_DIGITS = (*[2] * len(_PARTS), 1, 2, 2, 3, 2)
_SHEET = ("morphable", "morphable + refine", "elastic + refine")
_SIDES = ("three-quarter", "three-quarter-right")


@click.command()
@data_option
@out_option("DIR", "A folder for portrait.json, every figure of every face, and portrait.png.")
@click.option("--count", type=click.IntRange(1, 10_000), default=50, metavar="N", help="Faces to render.")
@click.option(
    "--noise",
    type=FiniteRange(0, 10),
    default=0.3,
    metavar="PERCENT",
    help="Of rendered landmarks: standard deviation of a coordinate, in percent of their diagonal.",
)
@click.option(
    "--pictures", type=PATH, metavar="DIR", help="Measure on these too: pictures, landmarks of the same name."
)
@seed_option
@overwrite_option
def command(dataset, out, count, noise, pictures, seed, overwrite):
    """Reconstruct, refine and texture portraits by every method and compare the errors.

    The portraits are test faces of a dataset, rendered in random poses and colours, and real pictures if there are any.
    Landmark errors are in percent of the landmarks' diagonal; the photometric error is the mean difference of colour to
    the picture inside the head, of full scale; the 3D error is the mean distance of the face's vertices after alignment
    in percent of the head's height. Seconds are without the texture.

    \b
    Example:
      caricli evaluate portrait --data dataset --out portraits
      caricli evaluate portrait --data dataset --count 10 --pictures drawings --out portraits
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.methods.evaluate.evaluate_portrait import COARSE, mean_figures, refinement_gains
    from caricli.render.contact_sheet import contact_sheet
    from caricli.store.datasets import dataset_files
    from caricli.store.models import check_topology, load_model

    pairs = [] if pictures is None else _pairs(pictures)
    inputs = (dataset, *dataset_files(dataset), pictures, *(path for pair in pairs for path in pair))
    with staged_folder(out, overwrite=overwrite, inputs=inputs, marker="portrait.json") as folder:
        data = read_dataset(dataset)
        rows = np.flatnonzero(data.rows("test"))
        if not len(rows):
            raise InputError(f"{shown(dataset)}: expected meshes in the test split, found none")
        models = {kind: load_model(kind=kind) for kind, *_ in COARSE.values()}
        for kind, model in models.items():
            check_topology(model.template, data.template, f"the bundled {kind} model")
            model.prepare()
        real = [_real(*pair) for pair in pairs]
        chosen = np.sort(np.random.default_rng(seed).permutation(rows)[:count])
        sets = {"rendered": _rendered(data, chosen, seed, noise)} | ({"pictures": real} if real else {})
        figures, refused, cells = {}, {}, []
        with progress_bar("reconstructing portraits") as report:
            done, total = 0, len(chosen) + len(real)
            for name, portraits in sets.items():
                figures[name] = {}
                for portrait in portraits:
                    show = len(figures[name]) < SHOWN
                    figures[name][portrait.name], said, drawn = _measured(portrait, models, show)
                    refused |= {f"{portrait.name}, {method}": reason for method, reason in said.items()}
                    cells += drawn
                    done += 1
                    report(done, total)
        means = {name: mean_figures(list(faces.values())) for name, faces in figures.items()}
        gains = refinement_gains(list(figures["rendered"].values()))
        recipe = provenance(
            "evaluate portrait",
            [dataset / "dataset.json", *(path for pair in pairs for path in pair)],
            seed,
            noise=noise,
            size=SIZE,
            texture=TEXTURE,
            models={kind: model.model_id for kind, model in models.items()},
        )
        found = {"means": means, "refinement": gains, "refused": refused, "faces": figures}
        write_json(folder / "portrait.json", recipe | found)
        drawn, labels = zip(*cells, strict=True)
        write_png(folder / "portrait.png", contact_sheet(drawn, 1 + len(_SHEET) + len(_SIDES), labels))
    for name, rivals in means.items():
        _print_table(f"{len(figures[name])} {name}", rivals)
    for name, gain in gains.items():
        change = f"{gain['before']:.3f} to {gain['after']:.3f} %, lower on {gain['better']} of {gain['faces']} faces"
        click.echo(f"refine takes the 3D error of {name} from {change}")
    for where, reason in refused.items():
        click.echo(f"refused: {where}: {reason}", err=True)


def _pairs(folder):
    """Pictures of a folder with their landmark files."""
    from caricli.store.pictures import PICTURES

    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder of pictures, found none")
    found = sorted(path for path in folder.iterdir() if path.suffix.lower() in PICTURES)
    if not found:
        raise InputError(f"{shown(folder)}: expected pictures, found none")
    pairs = []
    for path in found:
        marks = [path.with_suffix(suffix) for suffix in MARKS if path.with_suffix(suffix).is_file()]
        if not marks:
            raise InputError(f"{shown(path)}: expected landmarks beside it, with one of {', '.join(MARKS)}; found none")
        pairs.append((path, marks[0]))
    return pairs


def _real(path, marks_path):
    from caricli.io.landmarks import read_landmarks
    from caricli.methods.evaluate.evaluate_portrait import Portrait
    from caricli.store.pictures import read_picture

    marks = read_landmarks(marks_path)
    return Portrait(path.name, read_picture(path, marks, marks_path), marks.points)


def _rendered(data, rows, seed, noise):
    """Portraits of meshes of a dataset, one after the other."""
    from caricli.methods.evaluate.evaluate_portrait import PortraitStudio

    studio = PortraitStudio(data.template, SIZE)
    for row in rows:
        generator = np.random.default_rng([seed, int(row)])
        yield studio.portray(f"mesh {row}", data.vertices[row].astype(np.float64), generator, noise)


def _measured(portrait, models, show):
    """Figures of a portrait by method, what was refused, and pairs of picture and label, if they are to be shown."""
    from caricli.commands.textured import head_mask, paint
    from caricli.methods.evaluate.evaluate_portrait import ADJUSTED, measure_portrait, reconstruct_portrait
    from caricli.render.draw_textured import draw_textured
    from caricli.structures import Face

    try:
        found, refused = reconstruct_portrait(portrait.points, models)
    except CaricliError as error:
        raise type(error)(f"{portrait.name}: {error}") from error
    best, template = found["elastic"], models["intrinsic"].template
    # One mask for all: with a mask of its own a bad fit would be compared where it is good.
    mask = portrait.mask
    if mask is None:
        face = Face(template.with_vertices(best.vertices), landmarks=portrait.points)
        mask = head_mask(None, portrait.image, face, best.pose, template, (portrait.name, portrait.name))
    figures, rigs = {}, {}
    for name, each in found.items():
        figures[name] = measure_portrait(each, portrait, template)
        # What equation 7 adjusts is compared by its landmarks alone, as published.
        if name not in ADJUSTED:
            face = Face(template.with_vertices(each.vertices), landmarks=each.landmarks)
            generator = np.random.default_rng(0)
            painted = paint(face, each.pose, portrait.image, mask, template, TEXTURE, False, generator)
            figures[name]["photometric"], rigs[name] = 100 * painted.error, painted.rig
    if not show:
        return figures, refused, []
    cells = [_picture(portrait), *(_picture(portrait, found.get(name), template) for name in _SHEET)]
    cells += draw_textured(rigs.get(_SHEET[-1], rigs["elastic"]), _SIDES, VIEW)
    labels = [name if name in found else f"{name} refused" for name in _SHEET]
    return figures, refused, list(zip(cells, (portrait.name, *labels, "textured", "textured"), strict=True))


def _picture(portrait, found=None, template=None):
    """The portrait, or what was found drawn in its place; given landmarks are green, fitted ones red."""
    import cv2

    from caricli.render.fit_sheet import FITTED, GIVEN
    from caricli.render.overlay import draw_landmarks, overlay_mesh
    from caricli.render.place_eyeballs import place_eyeballs

    zoom = VIEW / max(portrait.image.shape[:2])
    picture = cv2.resize(portrait.image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    if found is None:
        return picture
    head = template.with_vertices(found.vertices)
    eyeballs = place_eyeballs(head, template.annotation)
    drawn = overlay_mesh(np.full_like(picture, 255), head, found.pose.zoomed(zoom), opacity=1, eyeballs=eyeballs)
    drawn = draw_landmarks(drawn, zoom * portrait.points, GIVEN, radius=2, hollow=True, lines=False)
    return draw_landmarks(drawn, zoom * found.landmarks, FITTED, radius=1, lines=False)


def _print_table(title, rivals):
    from rich.console import Console
    from rich.table import Column, Table

    table = Table(Column("method", no_wrap=True), *_PARTS.values(), *_REST, title=title)
    for name, row in rivals.items():
        cells = [row["nme"].get(part) for part in _PARTS]
        cells += row["pixels"]["all"], row.get("photometric"), row.get("shape"), row["flipped"], row["seconds"]
        pairs = zip(cells, _DIGITS, strict=True)
        table.add_row(name, *("-" if cell is None else f"{cell:.{digits}f}" for cell, digits in pairs))
    Console(width=None if Console().is_terminal else 120).print(table)
