"""caricli retarget: a caricature that does what a normal face does."""

from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from caricli.commands.shared.dynamic_texture import dynamic_texture_option, load_network, load_painter
from caricli.commands.shared.face_outputs import face_files, note_source, staged_face
from caricli.commands.shared.head_options import made_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    detector_option,
    model_option,
    named,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
    refuse_unread,
)
from caricli.commands.shared.picture import no_picture_option, write_picture
from caricli.commands.shared.redrawing import Redrawing, RedrawPaths, film_files
from caricli.errors import naming, shown
from caricli.io.outputs import check_folder, check_outputs, staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.io.video import check_video

if TYPE_CHECKING:
    from caricli.methods.expressions.retarget_rig import Retargeting
    from caricli.store.drivers import Drivers


@click.command()
@click.argument("rig", type=PATH, metavar="B.npz")
@click.argument("drivers", nargs=-1, required=True, type=PATH, metavar="NORMAL_FACE|PICTURE|LANDMARKS...")
@out_option("FACE.obj", f"Write the face of one driver here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many drivers into this folder, each under the name of its driver.")
@click.option(
    "--neutral", type=PATH, metavar="FACE", help="Take this as the neutral face of the person in the driving meshes."
)
@click.option(
    "--animation",
    type=PATH,
    metavar="ANIM.glb",
    callback=named(".glb"),
    help="Write the rig moving through all drivers in their order; ANIM.json goes beside it.",
)
@click.option(
    "--picture",
    type=PATH,
    metavar="DRAWING",
    help="Draw this picture, to which the face was fitted, again with the new expressions: --out takes a .png, and no "
    "faces are written.",
)
@click.option(
    "--parsing",
    type=PATH,
    metavar="LABELS.png",
    help="Take what is before the head in --picture from this label map, as `caricli detect` writes it.  [default: "
    "seen by the detector]",
)
@click.option(
    "--film",
    type=PATH,
    metavar="FILM.mp4",
    callback=named(".mp4", ".gif"),
    help="Write --picture with all drivers in their order as a film, MP4 or GIF; FILM.json goes beside it.",
)
@click.option(
    "--fps",
    type=FiniteRange(0, 240, min_open=True),
    default=25,
    metavar="N",
    help="Show N drivers a second in animation and film.",
)
@dynamic_texture_option("Paint the skin as the expression of each driver shows it.")
@made_head_options
@model_option
@detector_option
@pts_origin_option
@no_picture_option
@overwrite_option
@click.pass_context
def command(
    ctx,
    rig,
    drivers,
    out,
    out_dir,
    neutral,
    animation,
    picture,
    parsing,
    film,
    fps,
    dynamic,
    network,
    head,
    model,
    detector,
    pts_origin,
    overwrite,
):
    """Give a caricature the expressions of normal faces.

    B.npz is what `blendshapes` wrote. Drivers are meshes of the model's topology (NPZ, OBJ, PLY, GLB or glTF), or
    landmarks, or pictures, in which they are found; then they are written beside the result, FACE-landmarks.json.
    Weights from 0 to 1.5 explain what a driver does to a normal face, and are applied to the caricature: what no
    expression alone does is shared out among several. All drivers are of one person and of one kind. Place, size and
    unit (m, dm, cm or mm) do not matter. With --neutral a mesh tells who it is of; without it, and from landmarks, who
    somebody is and what he does are told apart by what is likely. Landmarks, and so pictures, show neither a tongue nor
    where eyes look: neither moves.

    With --picture the drawing itself takes the expressions: what it shows of the face moves, with its own colours; what
    it hides comes from the texture, teeth from the head; what the face uncovers is filled, and hair, glasses and hands
    before it stay. Where the drawing is transparent it stays so in a PNG; a film shows it on white. B.npz is then of a
    face with a camera, best one that `caricli texture` painted.

    With --dynamic-texture every face has a picture of its skin with the wrinkles, lips and shades of its expression.

    \b
    Example:
      caricli retarget b.npz smile.obj --neutral calm.obj --out smiling.obj
      caricli retarget b.npz photo.jpg --out face.obj
      caricli retarget b.npz take/*.obj --neutral calm.obj --out-dir frames --animation take.glb --fps 30
      caricli retarget b.npz smile.obj --picture drawing.png --out redrawn.png
      caricli retarget b.npz take/*.obj --picture drawing.png --film take.mp4
      caricli retarget b.npz smile.obj --dynamic-texture --out smiling.obj
    """
    from caricli.commands.shared.batch import run_batch
    from caricli.store.face_pictures import FaceReader
    from caricli.store.models import load_morphable

    paths = RetargetPaths(rig, drivers, neutral, out, out_dir, animation, RedrawPaths(picture, parsing, film), network)
    jobs = paths.jobs()
    refuse_unread(drivers, picture)
    given = {"overwrite": overwrite, "inputs": (*paths.inputs, model, detector)}
    paths.check_outputs(given, fps)
    painting = load_network(network, dynamic)
    normal = load_morphable(model)
    reader = FaceReader(detector, pts_origin)
    driven = _load_rig(rig, normal, head)
    painter = load_painter(driven, rig, painting, normal.template)
    loaded, retargeting = _load(driven, paths, normal, reader, painter)
    results = _Results(paths, given, loaded, retargeting, {"model_id": normal.model_id, "drivers": len(loaded.rows)})
    redrawing = None if picture is None else Redrawing(paths.again, retargeting, reader)
    results.write_moving(redrawing, fps)
    if redrawing is None:
        run_batch(ctx, jobs, results.write_face, "faces")
    else:
        run_batch(ctx, jobs, partial(results.write_picture, redrawing), "pictures")


@dataclass(frozen=True)
class RetargetPaths:
    """What is read and written.

    rig, drivers, neutral, out, out_dir, animation: as the options. again: RedrawPaths of what is drawn again. network:
    path of the texture network, or None.
    """

    rig: Path
    drivers: tuple[Path, ...]
    neutral: Path | None
    out: Path | None
    out_dir: Path | None
    animation: Path | None
    again: RedrawPaths
    network: Path | None = None

    @property
    def inputs(self) -> list[Path | None]:
        """What is read."""
        return [self.rig, self.neutral, *self.drivers, self.again.picture, self.again.parsing, self.network]

    @property
    def moving(self) -> list[Path]:
        """Animation and film, as far as they are wanted."""
        return [path for path in (self.animation, self.again.film) if path is not None]

    def jobs(self) -> list[tuple[Path, Path]]:
        """Drivers, each with the mesh or the picture to write of it.

        Raises UsageError for a mixture of drivers, a neutral face beside landmarks, options of a picture or of what
        moves without one, and names that two results have.
        """
        from caricli.commands.shared.batch import named_jobs
        from caricli.io.meshes.mesh import MESH_SUFFIXES
        from caricli.store.drivers import is_driving_mesh

        suffixes = MESH_SUFFIXES if self.again.picture is None else (".png",)
        alone = self.moving and self.out is None and self.out_dir is None
        if alone and self.again.film is None:
            # A GLB has one picture for all its frames.
            message = "--dynamic-texture and --picture are for --out, --out-dir and --film, not for --animation alone."
            refuse_typed(message, "dynamic", "picture")
        jobs = [] if alone else named_jobs(self.drivers, "NORMAL_FACE", self.out, self.out_dir, *suffixes)
        if self.again.picture is None and (self.again.film or self.again.parsing):
            raise click.UsageError("--film and --parsing are for --picture.")
        if self.again.picture is not None:
            refuse_typed(
                "--parts and --bust are for faces and --animation; --picture takes all of B.npz.", "parts", "bust"
            )
        if not self.moving:
            refuse_typed("--fps is for --animation and --film.", "fps")
        meshes = [is_driving_mesh(path) for path in self.drivers]
        if any(meshes) != all(meshes) or (self.neutral is not None and not meshes[0]):
            raise click.UsageError("Give either meshes, with or without --neutral, or landmarks without it.")
        reports = [path.with_suffix(".json") for path in (*(target for _, target in jobs), *self.moving)]
        if len(set(reports)) < len(reports):
            raise click.UsageError("--animation and --film need names that no other result has.")
        return jobs

    def check_outputs(self, given, fps):
        """Refuse what cannot be written before the drivers are read, which takes its time.

        given: to ``staged``. fps: frames a second of the film.
        """
        if self.again.film is not None:
            check_video(self.again.film, fps)
        for path in self.moving:
            check_outputs(*film_files(path), **given)
        if self.out is not None:
            check_outputs(*(face_files(self.out) if self.again.picture is None else film_files(self.out)), **given)
        if self.out_dir is not None:
            check_folder(self.out_dir)


def _load_rig(path, normal, head):
    """The Rig of a file with the parts that are chosen. normal: MorphableModel. head: HeadChoice."""
    from caricli.methods.parts.whole_head import choose_head
    from caricli.store.drivers import load_driven_rig

    rig = load_driven_rig(path, normal)
    with naming(path):
        return choose_head(rig, head)


def _load(driven, paths, normal, reader, painter):
    """The Drivers, and the Retargeting of those that could be read, or None.

    driven: Rig. paths: RetargetPaths. normal: MorphableModel. reader: FaceReader. painter: MoodPainter, or None.
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.expressions.retarget_rig import retarget_rig
    from caricli.store.drivers import load_drivers
    from caricli.store.faces import load_shape

    if paths.again.picture is not None:
        with naming(paths.rig):
            driven.require_depiction()
    calm = None if paths.neutral is None else load_shape(paths.neutral, normal)
    with progress_bar("reading") as progress:
        # One driver that cannot be read ends what moves through all of them.
        loaded = load_drivers(paths.drivers, normal, reader, progress, bool(paths.moving))
    if not loaded.faces:
        return loaded, None
    faces = [loaded.faces[path] for path in loaded.rows]
    return loaded, replace(retarget_rig(faces, driven, normal, calm), painter=painter)


@dataclass(frozen=True, eq=False)
class _Results:
    """What is written of a Retargeting.

    paths: RetargetPaths. given: to ``staged``. loaded: Drivers. about: what all reports say.
    """

    paths: RetargetPaths
    given: dict
    loaded: "Drivers"
    retargeting: "Retargeting"
    about: dict

    @cached_property
    def _stage(self):
        """What the sheets of all drivers share."""
        from caricli.render.sheets.driver_sheet import driver_stage

        return driver_stage(self.retargeting.rig)

    def write_face(self, path, target):
        """Write the files of a caricature with the expression of one driver, and say what it is."""
        from caricli.render.sheets.driver_sheet import driver_sheet
        from caricli.store.face_files import write_face_files
        from caricli.store.face_pictures import seen_files

        row = self.loaded.row(path)
        with staged_face(target, **self.given, optional=seen_files(path, target)) as (obj, npz, json, png):
            face = self.retargeting.caricature(row)
            write_face_files(obj, npz, face)
            write_json(json, self._description(path, obj) | self.retargeting.figures(row))
            write_picture(png, lambda: driver_sheet(_driver(self.retargeting, row), self._stage, face))
        return f"{shown(target)}: {self.retargeting.describe(row)}"

    def write_picture(self, redrawing, path, target):
        """Write the picture that is drawn again with the expression of one driver, and say what it is."""
        from caricli.store.face_pictures import seen_files

        row = self.loaded.row(path)
        with staged(*film_files(target), **self.given, optional=seen_files(path, target)) as (png, json):
            redrawing.write(png, json, row, self._description(path, png))
        return f"{shown(target)}: {self.retargeting.describe(row)}"

    def write_moving(self, redrawing, fps):
        """Write the animation of the rig and the film of the picture, where they are wanted, and say so."""
        from caricli.io.gltf.write_gltf import write_gltf

        about = self.about | {"weights": self.retargeting.weights_by_name()} if self.paths.moving else {}
        for path in self.paths.moving:
            with staged(*film_files(path), **self.given) as (moving, json):
                if path == self.paths.animation:
                    write_gltf(moving, self.retargeting.rig, animation=self.retargeting.animation(fps))
                else:
                    redrawing.write_film(moving, fps)
                write_json(json, provenance("retarget", self.paths.inputs, **about, fps=fps))
            echo_result(f"{shown(path)}: {self.about['drivers']} frames at {fps:.4g} a second")

    def _description(self, path, out):
        """What a report says of a driver; its landmarks are written beside a file."""
        more = note_source(out, self.loaded.sources.get(path), path)
        again = self.paths.again
        inputs = [self.paths.rig, path, self.paths.neutral, again.picture, again.parsing, self.paths.network]
        return provenance("retarget", inputs, **self.about, **more)


def _driver(retargeting, row):
    """The normal face of a Retargeting as a whole head."""
    from caricli.methods.parts.whole_head import whole_head
    from caricli.structures import Face

    driver = retargeting.driver(row)
    return whole_head(Face(driver), driver)
