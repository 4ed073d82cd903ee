"""caricli animate: a rig that moves as a face tracker says."""

from contextlib import ExitStack

import click

from caricli.commands.shared.head_options import made_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    WholeRange,
    named,
    named_numbers,
    overwrite_option,
)
from caricli.errors import naming, shown
from caricli.io.image import write_png
from caricli.io.mesh import write_mesh
from caricli.io.outputs import staged, staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.io.video import write_video
from caricli.io.worn import PictureNames, write_pictures

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
@click.option("--no-head", is_flag=True, help="Leave out the turning of the head.")
@made_head_options
@overwrite_option
def command(
    rig, weights, out, frames, kind, video, fps, source_fps, smooth, scales, view, size, no_head, head, overwrite
):
    """Move a RIG (NPZ or GLB) by the WEIGHTS of a face tracker, or by speech.

    WEIGHTS are a CSV of Live Link Face, a JSON of MediaPipe, an NPZ, or a JSON such as this:

    \b
      {"schema": "caricli.weights/1", "fps": 30, "names": ["jawOpen"], "weights": [[0.0], [0.5]]}

    Where the names are the fifteen visemes (sil, PP, ... ou), or WEIGHTS are mouth cues of Rhubarb Lip Sync (JSON, TSV
    or XML, of its letters or of visemes), the face speaks: shapes run into each other, and lips close for p, b and m.

    Names are bound by name; those that the rig lacks are listed. Weights are cut to 0 to 1, mouthClose to what jawOpen
    opens, then scaled. The head turns about the origin of the face frame: positive yaw to its own left, pitch down,
    roll to its right shoulder. A JSON beside the GLB (GLB's name), or the video (its name and .json), says what was
    done; among the frames it is animation.json.

    \b
    Example:
      caricli animate rig.npz take.csv --out talk.glb --smooth 1
      caricli animate rig.npz blendshapes.json --video talk.mp4 --fps 30 --scale jawOpen=1.3
      caricli animate rig.npz cues.json --out talk.glb --fps 60
      caricli animate rig.glb take.csv --frames frames --format png --view three-quarter
    """
    from caricli.methods.animate.animate_rig import AnimationSettings, animate_rig
    from caricli.store.tracks import load_track

    if out is None and frames is None and video is None:
        raise click.UsageError("Give at least one of --out, --frames and --video.")
    factors = named_numbers("--scale", scales, SCALE, "expression", (0, 3))
    first = out or video or frames
    # A video often lies beside a rig of its name, whose JSON is another.
    report_file = out.with_suffix(".json") if out else video and video.with_name(f"{video.name}.json")
    files = [path for path in (out, video, report_file) if path is not None]
    given = {"overwrite": overwrite, "inputs": (rig, weights)}
    with ExitStack() as stack:
        temporary = dict(zip(files, stack.enter_context(staged(*files, **given)), strict=True)) if files else {}
        folder = stack.enter_context(staged_folder(frames, marker=REPORT, **given)) if frames else None
        settings = AnimationSettings(fps, smooth, factors, not no_head)
        performance = animate_rig(_load(rig, head), load_track(weights, source_fps, fps), settings)
        _write_moving(temporary.get(out), temporary.get(video), performance, view, size)
        if folder is not None:
            _write_frames(folder, performance, kind, view, size)
        for path in [folder and folder / REPORT, temporary.get(report_file)]:
            if path is not None:
                write_json(path, provenance("animate", [rig, weights], **performance.figures()))
    _say(first, weights, performance)


def _load(path, head):
    """The Rig of a file with the parts that are chosen. head: HeadChoice."""
    from caricli.methods.parts.whole_head import choose_head
    from caricli.store.rig_sources import load_rig

    rig = load_rig(path)
    with naming(path):
        return choose_head(rig, head)


def _write_moving(glb, video, performance, view, size):
    """Write the rig with its animation, and the video, where there is a path."""
    from caricli.io.gltf.write_gltf import write_gltf

    if glb is not None:
        write_gltf(glb, performance.rig, animation=performance.animation)
    if video is not None:
        write_video(video, _pictures(performance, view, size), performance.fps)


def _write_frames(folder, performance, kind, view, size):
    """Write every frame as frame-0000.obj, with what the rig wears as frames-skin.png, or as frame-0000.png."""
    digits = max(4, len(str(len(performance.animation.times) - 1)))
    frames = _pictures(performance, view, size) if kind == "png" else _shapes(performance, "frames")
    face = performance.rig.face
    names = PictureNames() if kind == "png" else write_pictures(folder / "frames.obj", face.pictures)
    worn = {"mtl": folder / "frames.mtl", "others": names.others, "materials": face.materials}
    for k, frame in enumerate(frames):
        path = folder / f"frame-{k:0{digits}d}.{kind}"
        if kind == "png":
            write_png(path, frame)
        else:
            write_mesh(path, face.mesh.with_vertices(frame.astype(float)), names.skin, **worn)


def _pictures(performance, view, size):
    from caricli.render.rig_stage import RigStage

    return RigStage(performance.rig, view, size).pictures(_shapes(performance, "pictures"))


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
