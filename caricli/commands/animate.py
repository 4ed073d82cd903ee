"""caricli animate: a rig that moves as a face tracker says."""

from contextlib import ExitStack
from dataclasses import dataclass, replace
from difflib import get_close_matches

import click
import numpy as np

from caricli.commands.shared.options import PATH, FiniteRange, named, overwrite_option
from caricli.errors import InputError, shown
from caricli.io.image import write_png
from caricli.io.obj import write_obj
from caricli.io.outputs import staged, staged_folder
from caricli.io.provenance import provenance
from caricli.io.rig import read_rig
from caricli.io.strict_json import write_json
from caricli.io.track import read_weights
from caricli.io.video import write_video
from caricli.structures import Rig

REPORT = "animation.json"


@click.command()
@click.argument("rig", type=PATH)
@click.argument("weights", type=PATH)
@click.option("-o", "--out", type=PATH, metavar="ANIM.glb", callback=named(".glb"), help="The rig with its animation.")
@click.option("--frames", type=PATH, metavar="DIR", help="A folder for every frame as a file.")
@click.option("--format", "kind", type=click.Choice(["obj", "png"]), default="obj", help="Of the files in --frames.")
@click.option("--video", type=PATH, metavar="FILE", callback=named(".mp4", ".gif"), help="A video, .mp4 or .gif.")
@click.option("--fps", type=FiniteRange(0, 240, min_open=True), metavar="N", help="Frames a second.  [default: theirs]")
@click.option(
    "--source-fps",
    type=FiniteRange(0, 240, min_open=True),
    metavar="N",
    help="Frames a second of WEIGHTS where they do not say.  [default: 60 for CSV, else 30]",
)
@click.option(
    "--smooth", type=FiniteRange(0, 10), default=0, metavar="S", help="Calm the weights; 1 is usual, 0 leaves them."
)
@click.option("--scale", "scales", multiple=True, metavar="NAME=K", help="One expression times K, 0 to 3; repeat.")
@click.option("--view", type=click.Choice(["front", "three-quarter", "profile"]), default="front", help="Of pictures.")
@click.option("--size", type=click.IntRange(16, 4096), default=512, metavar="PIXELS", help="Side of a picture.")
@click.option("--no-head", is_flag=True, help="Leave out the turning of the head.")
@overwrite_option
def command(rig, weights, out, frames, kind, video, fps, source_fps, smooth, scales, view, size, no_head, overwrite):
    """Move a RIG (NPZ or GLB) by WEIGHTS: Live Link Face CSV, MediaPipe JSON, NPZ, or a JSON such as

    {"schema": "caricli.weights/1", "fps": 30, "names": ["jawOpen"], "weights": [[0.0], [0.5]]}.

    Names are bound by name; those that the rig lacks are listed. Weights are cut to 0 to 1, then scaled. The head turns
    about the origin of the face frame: positive yaw to its own left, pitch down, roll to its right shoulder. A JSON
    beside the GLB (GLB's name), or the video (its name and .json), says what was done; among the frames it is
    animation.json.

    \b
    Example:
      caricli animate rig.npz take.csv --out talk.glb --smooth 1
      caricli animate rig.npz blendshapes.json --video talk.mp4 --fps 30 --scale jawOpen=1.3
      caricli animate rig.glb take.csv --frames frames --format png --view three-quarter
    """
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.structures import Animation

    if out is None and frames is None and video is None:
        raise click.UsageError("Give at least one of --out, --frames and --video.")
    first = out or video
    # A video often lies beside a rig of its name, whose JSON is another.
    report_file = out.with_suffix(".json") if out else video and video.with_name(f"{video.name}.json")
    files = [path for path in (out, video, report_file) if path is not None]
    given = {"overwrite": overwrite, "inputs": (rig, weights)}
    with ExitStack() as stack:
        temporary = dict(zip(files, stack.enter_context(staged(*files, **given)), strict=True)) if files else {}
        folder = stack.enter_context(staged_folder(frames, marker=REPORT, **given)) if frames else None
        motion, report = _motion(rig, weights, fps, source_fps, smooth, _scales(scales), no_head)
        if out is not None:
            write_gltf(temporary[out], motion.rig, animation=Animation(motion.times, motion.weights, motion.turns))
        if video is not None:
            write_video(temporary[video], _pictures(motion, view, size), motion.fps)
        if folder is not None:
            _write_frames(folder, motion, kind, view, size)
        for path in (folder and folder / REPORT, report_file and temporary[report_file]):
            if path is not None:
                write_json(path, report)
    if report["unmatched"]:
        click.echo(f"{shown(weights)}: the rig lacks {shown(', '.join(report['unmatched']), 400)}", err=True)
    matched = f"{len(report['ranges'])} of {len(motion.rig.names)} expressions driven"
    click.echo(f"{shown(first or frames)}: {len(motion.times)} frames at {motion.fps:.4g} a second, {matched}")


@dataclass(frozen=True, eq=False)
class _Motion:
    """A rig, and for every frame its time, its weights (T, K) and the turning of the head (T, 4), or None."""

    rig: Rig
    fps: float
    times: np.ndarray
    weights: np.ndarray
    turns: np.ndarray | None


def _scales(texts):
    """A dict of names to factors."""
    scales = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        try:
            factor = float(value)
        except ValueError:
            factor = -1.0
        if not name or not 0 <= factor <= 3:
            raise InputError(f"--scale {text}: expected NAME=K with K from 0 to 3, such as jawOpen=1.3")
        scales[name] = factor
    if len(scales) < len(texts):
        raise InputError(f"--scale: expected every expression once, found {' '.join(texts)}")
    return scales


def _motion(rig_path, path, fps, source_fps, smooth, scales, no_head):
    """The _Motion that was asked for, and what the JSON says of it."""
    from caricli.io.gltf.read_gltf import read_gltf
    from caricli.methods.animate.bind_weights import bind_weights
    from caricli.methods.animate.resample_weights import resample_weights
    from caricli.methods.animate.smooth_weights import smooth_weights
    from caricli.methods.animate.turn_head import turn_head

    rig = (read_gltf if rig_path.suffix.lower() == ".glb" else read_rig)(rig_path)
    unknown = [name for name in scales if name not in rig.names]
    if unknown:
        near = get_close_matches(unknown[0], rig.names, 1, 0.0)[0]
        raise InputError(f"--scale {unknown[0]}: not among the rig's {len(rig.names)}; did you mean {near!r}?")
    track = read_weights(path, source_fps)
    head = None if no_head or track.head is None else smooth_weights(track.head, track.times, smooth)
    calm = smooth_weights(track.weights, track.times, smooth)
    track, fps = resample_weights(replace(track, weights=calm, head=head), fps)
    bound = bind_weights(track, rig.names)
    driven = [k for k, name in enumerate(rig.names) if name not in bound.undriven]
    weights = np.clip(bound.weights, 0, 1) * [scales.get(name, 1.0) for name in rig.names]
    report = provenance(
        "animate",
        [rig_path, path],
        fps=fps,
        frames=len(track.times),
        seconds=float(track.times[-1]),
        smooth=smooth,
        scale=scales,
        head=head is not None,
        unmatched=bound.unmatched,
        undriven=bound.undriven,
        clipped=int(np.count_nonzero((bound.weights < 0) | (bound.weights > 1))),
        ranges={rig.names[k]: [float(weights[:, k].min()), float(weights[:, k].max())] for k in driven},
    )
    return _Motion(rig, fps, track.times, weights, None if head is None else turn_head(track.head)), report


def _frames(motion, description):
    """Yield the vertices of every frame, the head turned; each is overwritten by the next."""
    from scipy.spatial.transform import Rotation

    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.animate.pose_rig import RigPoser

    poser = RigPoser(motion.rig)
    turns = None if motion.turns is None else Rotation.from_quat(motion.turns).as_matrix()
    with progress_bar(description) as report:
        for k, weights in enumerate(motion.weights):
            vertices = poser.pose(weights)
            yield vertices if turns is None else vertices @ turns[k].T
            report(k + 1, len(motion.weights))


def _pictures(motion, view, size):
    from caricli.render.draw_rig import draw_rig, neutral_sky

    sky = neutral_sky(motion.rig)
    return (draw_rig(motion.rig, vertices, view, size, sky) for vertices in _frames(motion, "pictures"))


def _write_frames(folder, motion, kind, view, size):
    """Write every frame as frame-0000.obj, with the rig's polygons and UVs, or as frame-0000.png."""
    digits = max(4, len(str(len(motion.times) - 1)))
    for k, frame in enumerate(_pictures(motion, view, size) if kind == "png" else _frames(motion, "frames")):
        path = folder / f"frame-{k:0{digits}d}.{kind}"
        if kind == "png":
            write_png(path, frame)
        else:
            write_obj(path, motion.rig.mesh.with_vertices(frame.astype(float)))
