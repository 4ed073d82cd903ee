"""caricli texture: the picture on the face."""

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click
import numpy as np

from caricli.commands.shared.dynamic_texture import load_network, network_option
from caricli.commands.shared.head_options import head_options
from caricli.commands.shared.notes import echo_edited, echo_notes, echo_numbering, echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    detector_option,
    model_option,
    out_option,
    overwrite_option,
    refuse_typed,
    seed_option,
)
from caricli.commands.shared.picture import SIZE, picture_files, picture_option
from caricli.errors import InputError, UsageError, naming, shown
from caricli.io.image import read_image, write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.texture.settings import Hair, PaintSettings, TextureSettings
from caricli.structures import Face

if TYPE_CHECKING:
    from caricli.methods.expressions.tools import ExpressionTools
    from caricli.methods.texture.paint_head import Painted
    from caricli.models.texture.model import TextureModel
    from caricli.structures.chart import FaceChart
    from caricli.template.template import Template

REPORT = "face.json"
UVS = ("head", "arap")
_OF_RETOUCHED = {"face", "image", "out", "retouched", "model", "overwrite"}
_FILE_NAME = re.compile(r"\w[\w .-]{0,63}")


@click.command()
@click.argument("face", type=PATH)
@click.argument("image", type=PATH)
@out_option(
    "DIR", "Write face.obj, .mtl, .npz, .glb, .json, sheet.png, texture.png, eyes.png, hair.png and bust.png in here."
)
@click.option(
    "--mask",
    type=PATH,
    metavar="MASK.png",
    help="Take the head from this picture, white where it is.  [default: found in the picture]",
)
@click.option(
    "--parsing",
    type=PATH,
    metavar="LABELS.png",
    help="Take head, hair and what is before them from this label map, as `caricli detect` writes it.  [default: seen "
    "by the detector]",
)
@click.option(
    "--size",
    type=WholeRange(64, 4096),
    metavar="PIXELS",
    help="Make the texture this wide and high.  [default: 1024 or more, as fine as the picture]",
)
@click.option(
    "--hair",
    type=click.Choice(get_args(Hair)),
    default=PaintSettings.hair,
    show_default=True,
    help="Make a shell of the hair in the picture, or leave it as paint on the head; auto makes one unless it is "
    "doubtful what is hair.",
)
@click.option(
    "--uv",
    type=click.Choice(UVS),
    default="head",
    show_default=True,
    help="arap: write the face by itself, too, laid out as rigidly as possible in a picture of its own, with what is "
    "between the lips: texture-arap.png and face-arap.obj, .mtl and .npz.",
)
@click.option(
    "--expressions",
    type=PATH,
    metavar="FILE",
    help="Paint the skin as every expression of this YAML or JSON file shows it, too: texture-NAME.png.",
)
@network_option
@click.option(
    "--retouched",
    is_flag=True,
    help="IMAGE is texture-arap.png of a FACE that is textured, changed by hand: bring it back onto the head.",
)
@head_options
@click.option("--project-uv", "flat", is_flag=True, help="Use the picture itself as texture, as published, to compare.")
@click.option("--keep-light", is_flag=True, help="Leave light and shade of the picture in the texture.")
@model_option
@detector_option
@seed_option
@picture_option
@overwrite_option
def command(
    face,
    image,
    out,
    mask,
    parsing,
    size,
    hair,
    uv,
    expressions,
    network,
    retouched,
    head,
    flat,
    keep_light,
    model,
    detector,
    seed,
    overwrite,
):
    """Paint a face (NPZ with a camera) with the picture that it was fitted to, before it is edited: edits keep paint.

    What the picture does not show comes from the other side of the face, and else has the colour of its skin, of what
    is seen of ears and neck, and of the hair; background, glasses, hats and hands never enter. The light of the picture
    is estimated and taken out, so that the head can stand in any other; face.json says what it was. eyes.png is painted
    in the colours of the eyes, with irises as large as the picture tells, upper lids have the line of lashes or ink
    that the picture shows along them, and teeth of an open mouth are as long as the label map shows them.
    `caricli rig` takes both pictures along.

    With --expressions there are pictures of the skin, wrinkles and lips with it, for expressions that the picture does
    not show; FILE is as for `caricli blendshapes`, and `caricli rig --mood NAME=texture-NAME.png` takes them along.

    With --retouched nothing is painted: face.obj, .mtl, .npz and .json have the texture that FACE wears, with what
    differs from it in its chart; the other options but --model say nothing then, and are refused.

    \b
    Example:
      caricli texture refined.npz drawing.png --out textured
      caricli texture face.npz photo.jpg --mask head.png --size 2048 --out textured
      caricli texture face.npz drawing.png --parsing drawing-regions.png --out textured
      caricli texture face.npz drawing.png --uv arap --out textured
      caricli texture face.npz drawing.png --expressions moods.yaml --out textured
      caricli texture textured/face.npz edited-arap.png --retouched --out retouched
      caricli rig textured/face.npz --out rig.glb
    """
    settings = PaintSettings(size, flat, seed, hair, head, TextureSettings(keep_light=keep_light))
    if sum(path is not None for path in (mask, parsing, detector)) > 1:
        raise UsageError("--mask, --parsing and --detector all say where the head is: give one of them")
    if flat and (size or keep_light or hair == "shell"):
        raise UsageError("--project-uv takes the picture as it is, without --size, --keep-light and --hair shell")
    if retouched:
        others = set(click.get_current_context().params) - _OF_RETOUCHED
        refuse_typed("--retouched takes no other options than --out, --model and --overwrite.", "picture", *others)
        echo_result(_retouch(face, image, out, model, overwrite))
        return
    painting = Expressions.load(expressions, network)
    task = TextureTask(mask, settings, model, overwrite, detector, parsing, uv == "arap", painting)
    echo_result(task.run(face, image, out))


@dataclass(frozen=True, eq=False)
class Expressions:
    """Expressions in which the skin is painted. tools: ExpressionTools of them. network: TextureModel. files: that were
    read.
    """

    tools: "ExpressionTools"
    network: "TextureModel"
    files: Sequence[Path]

    @classmethod
    def load(cls, expressions: Path | None, network: Path | None) -> "Expressions | None":
        """Those of a file, or None. network: path, or None for the bundled one. Raises InputError, UsageError."""
        model = load_network(network, expressions is not None, "--expressions")
        if model is None:
            return None
        from caricli.store.expression_tools import ToolPaths, load_tools
        from caricli.store.faces import CHARTED_PICTURE

        tools, files = load_tools(ToolPaths(expressions))
        for name in tools.expressions:
            if not _FILE_NAME.fullmatch(name) or f"texture-{name}.png" == CHARTED_PICTURE:
                raise InputError(f"{shown(expressions)}: expected names that files can have, found {shown(name, 60)!r}")
        return cls(tools, model, [*files, *([network] if network else [])])

    def write(self, folder: Path, face: Face, given: Path) -> None:
        """Write texture-NAME.png of every expression; what its picture does not tell is said. given: path of the face.

        face: Face with its texture.
        """
        from caricli.methods.dynamic.paint_expressions import paint_expressions

        with naming(given):
            moods, notes = paint_expressions(face, self.tools, self.network)
        echo_notes(*(f"{shown(given)}: {note}" for note in notes))
        for mood in moods:
            write_png(folder / f"texture-{mood.name}.png", mood.skin)


@dataclass(frozen=True)
class TextureTask:
    """What is done with a face and its picture.

    mask: path of a picture that is white where the head is, or None to cut it out. settings: PaintSettings. model:
    path of the model of the mesh, or None. overwrite: whether a folder that exists is replaced. detector:
    path of what says what the pixels show, or None for the bundled one; a mask goes without. parsing: path of a label
    map that says it in its place, or None. chart: whether the face is written in the chart, too. expressions:
    Expressions in which it is painted, too, or None.
    """

    mask: Path | None = None
    settings: PaintSettings = PaintSettings()
    model: Path | None = None
    overwrite: bool = False
    detector: Path | None = None
    parsing: Path | None = None
    chart: bool = False
    expressions: Expressions | None = None

    def run(self, face: Path, image: Path, out: Path) -> str:
        """Paint a face, write the head into a folder, and say how near it came."""
        from caricli.commands.shared.progress import progress_bar

        files = () if self.expressions is None else self.expressions.files
        inputs = (face, image, self.mask, self.parsing, *files)
        folders = staged_folder(
            out, overwrite=self.overwrite, inputs=(*inputs, self.model, self.detector), marker=REPORT
        )
        with folders as folder, progress_bar("painting"):
            painted = self._write(folder, inputs)
        return f"{out}: {painted.describe()}"

    def _write(self, folder: Path, inputs: tuple[Path | None, ...]) -> "Painted":
        """Paint a face and write the head into a folder. inputs: paths, of face and picture first."""
        from caricli.methods.texture.paint_head import paint_head
        from caricli.render.in_parallel import do_in_parallel
        from caricli.render.load_kernels import load_kernels
        from caricli.store.faces import load_seen_face, write_painted_head

        face, image, *_ = inputs
        assert face is not None and image is not None
        seen, shape_model = load_seen_face(face, self.model)
        picture = read_image(image)
        with naming(face):
            points = seen.require_landmarks()
        chart = self._chart_of(shape_model.template, self.model or face)
        (white, regions), _ = do_in_parallel(partial(self._shown, image, picture, points), load_kernels)
        sheets = picture_files(folder / "sheet.png")
        settings = replace(self.settings, sky=bool(sheets))
        start = time.perf_counter()
        with naming(", ".join(str(path) for path in inputs if path)):
            painted = paint_head(seen, shape_model.template, picture, white, settings, regions)
        seconds = time.perf_counter() - start
        effect = "paint as far from its place; paint first, edits keep it"
        echo_edited(face, seen, shape_model.template, effect)
        jobs: list[Callable[[], None]] = [partial(write_painted_head, folder, painted)]
        if chart is not None:
            from caricli.methods.dynamic.face_in_chart import face_in_chart
            from caricli.store.faces import write_charted_face

            charted = face_in_chart(painted, seen, picture, chart)
            jobs.append(partial(write_charted_face, folder, charted))
        if self.expressions is not None:
            self.expressions.write(folder, replace(seen, mesh=painted.head, pictures=painted.pictures), face)
        jobs += [partial(_draw_sheet, p, picture, points, painted) for p in sheets]
        about = {"project_uv": self.settings.project_uv, "seconds": seconds, "head": painted.filled}
        about |= {"model_id": shape_model.model_id} | painted.figures()
        write_json(folder / REPORT, provenance("texture", inputs, self.settings.seed, **about))
        do_in_parallel(*jobs)
        return painted

    def _chart_of(self, template: "Template", source: Path) -> "FaceChart | None":
        """The chart of a template, where the face is written in it. source: path that errors name."""
        if not self.chart:
            return None
        from caricli.template.chart import face_chart

        with naming(source):
            return face_chart(template)

    def _shown(
        self, path: Path, picture: np.ndarray, points: np.ndarray
    ) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Of a path's picture (H, W, 3) and the landmarks (L, 2) of its face: the mask (H, W) of its head, bool, and
        (H, W) values of Region; None where there is none. Raises InputError where neither is given and the picture
        surely shows its face elsewhere.
        """
        from caricli.store.face_pictures import FaceReader
        from caricli.store.pictures import load_mask, load_regions

        size = (picture.shape[1], picture.shape[0])
        if self.mask is not None:
            return load_mask(self.mask, size), None
        if self.parsing is not None:
            regions = load_regions(self.parsing, size, points)
            echo_numbering(self.parsing)
            return None, regions
        given = FaceReader(self.detector).given(picture, points)
        if given.elsewhere:
            raise InputError(
                f"{shown(path)}: expected the picture that the face was fitted to, found a face in another place; with "
                "--mask or --parsing it is painted all the same"
            )
        return None, given.regions


def _retouch(path, image, out, model, overwrite):
    """Write a face with a texture that was changed in its chart, and say how much of it was."""
    from caricli.methods.dynamic.retouch_texture import retouch_texture
    from caricli.store.face_files import write_face_files
    from caricli.store.faces import load_seen_face
    from caricli.template.chart import face_chart

    with staged_folder(out, overwrite=overwrite, inputs=(path, image, model), marker=REPORT) as folder:
        face, shape_model = load_seen_face(path, model)
        picture = read_image(image)
        with naming(path):
            chart = face_chart(shape_model.template)
        with naming(f"{path}, {image}"):
            result = retouch_texture(face, picture, chart)
        worn = replace(face, pictures=replace(face.pictures, skin=result.texture))
        write_face_files(folder / "face.obj", folder / "face.npz", worn)
        figures = {"retouched": result.touched, "alike": result.alike}
        write_json(folder / REPORT, provenance("texture", [path, image], **figures))
    doubt = result.doubt()
    echo_notes(doubt and f"{shown(image)}: {doubt}")
    return f"{shown(out)}: {100 * result.touched:.1f} % of the face retouched"


def _draw_sheet(path, picture, points, painted):
    """Write a picture with landmarks (L, 2), and the Painted head beside it."""
    from caricli.render.sheets.texture_sheet import texture_sheet

    write_png(path, texture_sheet(picture, points, painted.rig, SIZE, painted.sky))
