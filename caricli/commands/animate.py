"""caricli animate: a rig that moves as a face tracker says."""

import os
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from caricli.commands.shared.dynamic_texture import dynamic_texture_option, load_network, load_painter
from caricli.commands.shared.head_options import made_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    WholeRange,
    named,
    named_numbers,
    overwrite_option,
    refuse_typed,
)
from caricli.errors import naming, shown
from caricli.io.image import write_png
from caricli.io.meshes.mesh import write_mesh
from caricli.io.outputs import staged, staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.io.video import check_video, write_video
from caricli.io.worn import PictureNames, write_pictures

if TYPE_CHECKING:
    from caricli.methods.animate.animate_rig import Performance
    from caricli.methods.dynamic.rig_moods import MoodPainter

REPORT = "animation.json"
SCALE = "NAME=K with K from 0 to 3, such as jawOpen=1.3"


@click.command()
@click.argument("rig", type=PATH)
@click.argument("weights", type=PATH)
@click.option(
    "-o", "--out", type=PATH, metavar="ANIM.glb", callback=named(".glb"), help="Write the rig with its animation here."
)
@click.option("--frames", type=PATH, metavar="DIR", help="Write every frame as a file into this folder.")
@click.option(
    "--format",
    "kind",
    type=click.Choice(["obj", "png"]),
    default="obj",
    help="Write the files of --frames as meshes (obj) or pictures (png).",
)
@click.option(
    "--video",
    type=PATH,
    metavar="FILE",
    callback=named(".mp4", ".gif"),
    help="Write a video here, as .mp4 (H.264) or .gif.",
)
@click.option(
    "--fps",
    type=FiniteRange(0, 240, min_open=True),
    metavar="N",
    help="Make N frames a second.  [default: as many as WEIGHTS have]",
)
@click.option(
    "--source-fps",
    type=FiniteRange(0, 240, min_open=True),
    metavar="N",
    help="Read WEIGHTS at N frames a second where they do not say.  [default: 60 for CSV, else 30]",
)
@click.option(
    "--smooth", type=FiniteRange(0, 10), default=0, metavar="S", help="Calm the weights: 1 is usual, 0 leaves them."
)
@click.option(
    "--scale",
    "scales",
    multiple=True,
    metavar="NAME=K",
    help="Multiply an expression by K, from 0 to 3; repeat for more.",
)
@click.option(
    "--view",
    type=click.Choice(["front", "three-quarter", "profile"]),
    default="front",
    help="Draw pictures from this side.",
)
@click.option(
    "--size", type=WholeRange(16, 4096), default=512, metavar="PIXELS", help="Draw pictures this wide and high."
)
@dynamic_texture_option("Paint the skin in every frame of video and pictures as its expression shows it.")
@click.option("--no-head", is_flag=True, help="Leave out the turning of the head.")
@made_head_options
@overwrite_option
def command(
    rig,
    weights,
    out,
    frames,
    kind,
    video,
    fps,
    source_fps,
    smooth,
    scales,
    view,
    size,
    dynamic,
    network,
    no_head,
    head,
    overwrite,
):
    """Move a RIG (NPZ, GLB or glTF) by the WEIGHTS of a face tracker, or by speech.

    WEIGHTS are a CSV of Live Link Face, a JSON of MediaPipe, an NPZ, or a JSON such as this:

    \b
      {"schema": "caricli.weights/1", "fps": 30, "names": ["jawOpen"], "weights": [[0.0], [0.5]]}

    Where the names are the fifteen visemes (sil, PP, ... ou), or WEIGHTS are mouth cues of Rhubarb Lip Sync (JSON, TSV
    or XML, of its letters or of visemes), the face speaks: shapes run into each other, and lips close for p, b and m.

    Names are bound by name, mouthSmile to both its sides, or the one there is; those that the rig lacks are listed.
    Weights are cut to 0 to 1, scaled, and cut again: mouthClose, which goes by the scale of jawOpen unless it has its
    own, to what jawOpen opens, eyeSquint to what eyeBlink leaves open. The head turns about the origin of the face
    frame: positive yaw to its own left, pitch down, roll to its right shoulder. A JSON beside the GLB (GLB's name), or
    the video (its name and .json), says what was done; among the frames it is animation.json.

    With --dynamic-texture the skin of a textured RIG is painted anew for every frame of --video, and of --frames as
    pictures. Best is an NPZ of `blendshapes`, which says what its picture shows and what its expressions are made of.

    \b
    Example:
      caricli animate rig.npz take.csv --out talk.glb --smooth 1
      caricli animate rig.npz blendshapes.json --video talk.mp4 --fps 30 --scale jawOpen=1.3
      caricli animate rig.npz cues.json --out talk.glb --fps 60
      caricli animate rig.glb take.csv --frames frames --format png --view three-quarter
      caricli animate blendshapes.npz take.csv --video take.mp4 --dynamic-texture
    """
    from caricli.methods.animate.animate_rig import AnimationSettings

    _check_outputs(out, video, frames, kind)
    model = load_network(network, dynamic)
    factors = named_numbers("--scale", scales, SCALE, "expression", (0, 3))
    # A video often lies beside a rig of its name, whose JSON is another.
    report_file = out.with_suffix(".json") if out else video and video.with_name(f"{video.name}.json")
    files = [path for path in (out, video, report_file) if path is not None]
    given = {"overwrite": overwrite, "inputs": (rig, weights, network)}
    with ExitStack() as stack:
        temporary = dict(zip(files, stack.enter_context(staged(*files, **given)), strict=True)) if files else {}
        folder = stack.enter_context(staged_folder(frames, marker=REPORT, **given)) if frames else None
        loaded = _load(rig, head)
        painter = load_painter(loaded, rig, model)
        settings = AnimationSettings(fps, smooth, factors, not no_head)
        performance = _perform(loaded, rig, weights, source_fps, settings)
        if video is not None:
            check_video(video, performance.fps)
        drawing = _Drawing(performance, painter, view, size)
        _write_moving(temporary.get(out), temporary.get(video), drawing)
        if folder is not None:
            _write_frames(folder, drawing, kind)
        reports = [folder and folder / REPORT, temporary.get(report_file)]
        _write_reports([path for path in reports if path], [rig, weights, network], drawing)
    _say(out or video or frames, weights, performance)


def _check_outputs(out, video, frames, kind):
    """Refuse outputs that contradict each other, and options of pictures where none is drawn. kind: of the files in
    frames. Raises UsageError."""
    if out is None and frames is None and video is None:
        raise click.UsageError("Give at least one of --out, --frames and --video.")
    if frames is None:
        refuse_typed("--format is of the files of --frames.", "kind")
    places = [Path(os.path.realpath(path)) for path in (out, video) if path]
    if frames and any(place.is_relative_to(os.path.realpath(frames)) for place in places):
        raise click.UsageError(
            "--out and --video take files outside of the folder of --frames, which is written whole."
        )
    if not (video or (frames and kind == "png")):
        message = "--dynamic-texture, --view and --size are for --video, and for --frames with --format png."
        refuse_typed(message, "dynamic", "view", "size")


def _load(path, head):
    """The Rig of a file with the parts that are chosen. head: HeadChoice."""
    from caricli.methods.parts.whole_head import choose_head
    from caricli.store.rig_sources import load_rig

    rig = load_rig(path)
    with naming(path):
        return choose_head(rig, head)


def _perform(rig, path, weights, source_fps, settings):
    """The Performance of a Rig of a file. weights: path of what moves it. settings: AnimationSettings."""
    from caricli.methods.animate.animate_rig import animate_rig, check_rig
    from caricli.store.tracks import load_track

    with naming(path):
        check_rig(rig, settings)
    track = load_track(weights, source_fps, settings.fps)
    with naming(weights):
        return animate_rig(rig, track, settings)


@dataclass(frozen=True, eq=False)
class _Drawing:
    """How a Performance is drawn. painter: MoodPainter of its skin, or None. view, size: as the options."""

    performance: "Performance"
    painter: "MoodPainter | None"
    view: str
    size: int

    def pictures(self):
        """Every frame, (size, size, 3) uint8."""
        from caricli.render.rig_stage import RigStage

        stage = RigStage(self.performance.rig, self.view, self.size)
        return stage.pictures(_shapes(self.performance, "pictures"), self._paint if self.painter else None)

    def _paint(self, number):
        return self.painter.paint(self.performance.animation.weights[number])


def _write_moving(glb, video, drawing):
    """Write the rig with its animation, and the video, where there is a path."""
    from caricli.io.gltf.write_gltf import write_gltf

    performance = drawing.performance
    if glb is not None:
        write_gltf(glb, performance.rig, animation=performance.animation)
    if video is not None:
        write_video(video, drawing.pictures(), performance.fps)


def _write_reports(paths, inputs, drawing):
    """Write what was done with inputs."""
    about = drawing.performance.figures() | ({} if drawing.painter is None else {"dynamic_texture": True})
    for path in paths:
        write_json(path, provenance("animate", [given for given in inputs if given], **about))


def _write_frames(folder, drawing, kind):
    """Write every frame as frame-0000.obj, with what the rig wears as frames-skin.png, or as frame-0000.png."""
    performance = drawing.performance
    digits = max(4, len(str(len(performance.animation.times) - 1)))
    frames = drawing.pictures() if kind == "png" else _shapes(performance, "frames")
    face = performance.rig.face
    names = PictureNames() if kind == "png" else write_pictures(folder / "frames.obj", face.pictures)
    worn = {"mtl": folder / "frames.mtl", "others": names.others | face.pictures.finishes, "materials": face.materials}
    for k, frame in enumerate(frames):
        path = folder / f"frame-{k:0{digits}d}.{kind}"
        if kind == "png":
            write_png(path, frame)
        else:
            write_mesh(path, face.mesh.with_vertices(frame.astype(float)), names.skin, **worn)


def _shapes(performance, description):
    """Vertices of every frame, with a bar."""
    from caricli.commands.shared.progress import progress_bar

    with progress_bar(description) as report:
        yield from performance.frames(report)


def _say(out, weights, performance):
    """Print what the rig lacks, and what was written."""
    unmatched = performance.bound.unmatched
    if unmatched:
        click.echo(f"{shown(weights)}: the rig lacks {shown(', '.join(unmatched), 400)}", err=True)
    counts = f"{len(performance.driven)} of {len(performance.rig.names)} expressions driven"
    frames = len(performance.animation.times)
    echo_result(f"{shown(out)}: {frames} frames at {performance.fps:.4g} a second, {counts}")
