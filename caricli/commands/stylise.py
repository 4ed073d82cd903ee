"""caricli stylise: portraits made caricatures and painted, before a face is reconstructed from them."""

from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from caricli.commands.shared.batch import named_jobs, run_batch
from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    detector_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
    seed_option,
)
from caricli.commands.shared.picture import picture_files, picture_option, write_picture
from caricli.errors import naming, shown
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.stylise.settings import SHAPES, STYLES, StyliseSettings
from caricli.store.pictures import load_marked_picture
from caricli.structures.detection import FacePicture
from caricli.structures.landmarks import SCHEMES

if TYPE_CHECKING:
    from caricli.methods.stylise.exaggerate_portrait import ShapeTools
    from caricli.methods.stylise.stylise_portrait import Stylised
    from caricli.store.face_pictures import FaceReader
    from caricli.store.generators import LoadedGenerator

USUAL = StyliseSettings()


@click.command()
@click.argument("portraits", nargs=-1, required=True, type=PATH, metavar="PORTRAIT...")
@click.option(
    "--style",
    type=click.Choice(STYLES),
    help=f"Paint the picture with this, or leave its pixels (none).  [default: {USUAL.style}]",
)
@click.option(
    "--shape",
    type=click.Choice(SHAPES),
    default=USUAL.shape,
    help="Go where the landmark map sees a caricature's landmarks, for faces that are none yet (map), towards what "
    "caricatures have in common (direction), away from the mean head (own), or nowhere (none).",
)
@click.option(
    "--strength",
    type=FiniteRange(0, 3),
    default=USUAL.strength,
    metavar="S",
    help="Exaggerate so much: 0 changes nothing, 1 shows clearly, 2 is strong.",
)
@out_option("P.png", "Write the picture of one portrait here; its files go beside it.", required=False)
@out_folder_option("Write the pictures of many portraits into this folder, under their names.")
@click.option(
    "--landmarks",
    type=PATH,
    metavar="FILE",
    help="Take these 68 or 81 landmarks of the one PORTRAIT.  [default: found in it]",
)
@click.option(
    "--generator",
    metavar="COMMAND|FILE",
    help="Paint with this in place of a style: a command with {input} and {output}, or a TorchScript file.",
)
@click.option(
    "--timeout",
    type=FiniteRange(0.1, 86400),
    default=600.0,
    metavar="SECONDS",
    help="Wait so long for the command of --generator.",
)
@model_option
@detector_option
@pts_origin_option
@seed_option
@picture_option
@overwrite_option
@click.pass_context
def command(
    ctx, portraits, style, shape, strength, out, out_dir, landmarks, generator, timeout, detector, model, pts_origin,
    seed, overwrite,
):  # fmt: skip
    """Make portraits caricatures: their shape, and what they are painted with.

    The face is reconstructed and exaggerated, and the picture follows its mesh; hair and background give way smoothly.
    A portrait that is transparent in places is laid on white before, and P.png is opaque.
    Beside P.png go P.json, the landmarks of the face in it, exactly where its pixels went; P-report.json; and
    P-sheet.png, with the portrait before and after. `caricli reconstruct-from-landmarks P.json --image P.png` goes on.

    A command of --generator reads the PNG {input} and writes {output}. A TorchScript file maps a float32 tensor
    (1, 3, H, W), sRGB from 0 to 1, to another. Both keep size and place; where yours moves the face, find it again with
    `caricli detect`. A generator is a program and may do what you may: run only those that you trust.

    \b
    Example:
      caricli stylise photo.jpg --style oil --out painted.png
      caricli stylise photos/*.jpg --style ink --shape own --strength 2 --out-dir drawn
      caricli stylise photo.jpg --generator "python toon.py {input} {output}" --out toon.png
    """
    from caricli.store.face_pictures import FaceReader
    from caricli.store.generators import load_generator
    from caricli.store.shape_tools import load_shape_tools

    _check_usage(portraits, style, shape, landmarks, generator)
    jobs = named_jobs(portraits, "PORTRAIT", out, out_dir, ".png")
    settings = StyliseSettings(style or ("none" if generator else USUAL.style), shape, strength, seed)
    painter = None if generator is None else load_generator(generator, timeout)
    tools = load_shape_tools(settings, model)
    reader = FaceReader(detector, pts_origin)
    inputs = (*portraits, landmarks, model, detector)
    task = StyliseTask(reader, landmarks, tools, settings, painter, generator, inputs, overwrite)
    run_batch(ctx, jobs, task.run, "portraits")


def _check_usage(portraits, style, shape, landmarks, generator):
    """Refuse options that contradict each other, or say nothing beside others."""
    if landmarks is not None and len(portraits) > 1:
        raise click.UsageError("--landmarks are of one PORTRAIT; without them they are found in each.")
    if generator is not None and style is not None:
        raise click.UsageError("Give either --style or --generator.")
    if landmarks is not None:
        refuse_typed("--detector finds landmarks, and --landmarks gives them: give one of them.", "detector")
    else:
        refuse_typed("--pts-origin is of --landmarks.", "pts_origin")
    if generator is None:
        refuse_typed("--timeout is for the command of --generator.", "timeout")
    if generator is not None or style == "none":
        refuse_typed("--seed is for what a --style paints.", "seed")
    if shape == "none":
        refuse_typed("--strength and --model are for another --shape than none.", "strength", "model")


@dataclass(frozen=True, eq=False)
class StyliseTask:
    """What is done with every portrait.

    reader: FaceReader. marks: path of the landmarks, or None where they are found. tools: ShapeTools, or None where
    none are needed. settings: StyliseSettings. painter: LoadedGenerator and typed: how it was given, or None. inputs:
    files that are read. overwrite: whether files that exist are replaced.
    """

    reader: "FaceReader"
    marks: Path | None
    tools: "ShapeTools | None"
    settings: StyliseSettings
    painter: "LoadedGenerator | None"
    typed: str | None
    inputs: tuple[Path | None, ...]
    overwrite: bool

    def run(self, source: Path, target: Path) -> str:
        """Stylise a portrait, write it and what belongs to it, and say how far it went."""
        from caricli.methods.stylise.stylise_portrait import stylise_portrait

        paint = None if self.painter is None else self.painter.paint
        marks_file, report_file = target.with_suffix(".json"), target.with_name(f"{target.stem}-report.json")
        sheets = picture_files(target.with_name(f"{target.stem}-sheet.png"))
        inputs = (*self.inputs, *self._sources(source))
        with staged(target, marks_file, report_file, *sheets, overwrite=self.overwrite, inputs=inputs) as files:
            picture = self._read(source)
            assert picture.pixels is not None
            with naming(source):
                stylised = stylise_portrait(picture.pixels, picture.landmarks, self.tools, self.settings, paint)
            write_png(files[0], stylised.picture)
            write_landmarks(files[1], stylised.landmarks)
            write_json(files[2], self._report(source, picture, stylised))
            for sheet in files[3:]:
                write_picture(sheet, partial(self._sheet, picture.pixels, stylised))
        echo_notes(picture.note(source))
        return f"{shown(target)}: {self._paint()}, landmarks moved by {stylised.moved:.2f} % of their diagonal"

    def _read(self, source: Path) -> FacePicture:
        """A portrait and the landmarks of its face, given or found."""
        if self.marks is not None:
            return FacePicture(*load_marked_picture(self.marks, source, self.reader.pts_origin))
        count = max(SCHEMES) if self.tools is None else len(self.tools.model.template.annotation.landmarks)
        pixels = read_image(source)
        with naming(source):
            seen = self.reader.see(pixels)
        return FacePicture(seen.landmarks.first(count), pixels, seen, seen.regions)

    def _sources(self, source: Path) -> list[Path | None]:
        """Files that a picture comes from."""
        return [source, self.marks, None if self.painter is None else self.painter.file]

    def _paint(self) -> str:
        """What the picture is painted with, in a word."""
        return "no paint" if self.painter is None and self.settings.style == "none" else self._painter()

    def _painter(self) -> str:
        return self.settings.style if self.painter is None else "generator"

    def _report(self, source: Path, picture: FacePicture, stylised: "Stylised") -> dict[str, Any]:
        """What was done, so that it can be done again."""
        about = {key: value for key, value in asdict(self.settings).items() if key != "seed"}
        model = None if self.tools is None else self.tools.model.model_id
        about |= {"generator": self.typed, "model_id": model, "moved": stylised.moved} | picture.figures()
        return provenance("stylise", self._sources(source), self.settings.seed, **about)

    def _sheet(self, image: np.ndarray, stylised: "Stylised") -> np.ndarray:
        """The picture of a portrait before and after."""
        from caricli.render.sheets.stylise_sheet import stylise_sheet

        shape = {} if self.tools is None else {f"{self.settings.shape} {self.settings.strength:g}": stylised.warped}
        painted = {} if self._paint() == "no paint" else {self._painter(): stylised.picture}
        return stylise_sheet({"given": image} | shape | painted, stylised.landmarks.points)
