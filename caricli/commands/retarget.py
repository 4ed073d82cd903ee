"""caricli retarget: a caricature that does what a normal face does."""

import click

from caricli.commands.shared.face_outputs import note_source, staged_face
from caricli.commands.shared.head_options import made_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    detector_option,
    face_files,
    model_option,
    named,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
)
from caricli.commands.shared.picture import picture_option, write_picture
from caricli.errors import naming, shown
from caricli.io.outputs import check_folder, check_outputs, staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


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
    "--fps",
    type=FiniteRange(0, 240, min_open=True),
    default=25,
    metavar="N",
    help="Show N drivers a second in the animation.",
)
@made_head_options
@model_option
@detector_option
@pts_origin_option
@picture_option
@overwrite_option
@click.pass_context
def command(ctx, rig, drivers, out, out_dir, neutral, animation, fps, head, model, detector, pts_origin, overwrite):
    """Give a caricature the expressions of normal faces.

    B.npz is what `blendshapes` wrote. Drivers are meshes of the model's topology (NPZ, OBJ, PLY, GLB or glTF), or
    landmarks, or pictures, in which they are found; then they are written beside the result, FACE-landmarks.json.
    Weights from 0 to 1.5 explain what a driver does to a normal face, and are applied to the caricature. All drivers
    are of one person and of one kind. Place and size do not matter. Weights of meshes are exact with --neutral; without
    it, and from landmarks, who somebody is and what he does are told apart by what is likely.

    \b
    Example:
      caricli retarget b.npz smile.obj --neutral calm.obj --out smiling.obj
      caricli retarget b.npz photo.jpg --out face.obj
      caricli retarget b.npz take/*.obj --neutral calm.obj --out-dir frames --animation take.glb --fps 30
    """
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.io.mesh import MESH_SUFFIXES
    from caricli.store.face_pictures import FaceReader, seen_files
    from caricli.store.models import load_morphable

    jobs = named_jobs(drivers, "NORMAL_FACE", out, out_dir, *MESH_SUFFIXES)
    _check_usage(drivers, neutral, animation, [target for _, target in jobs])
    given = {"overwrite": overwrite, "inputs": (rig, neutral, model, detector, *drivers)}
    _check_outputs(out, out_dir, animation, given)
    normal = load_morphable(model)
    reader = FaceReader(detector, pts_origin)
    loaded, retargeting = _load(_load_rig(rig, normal, head), drivers, neutral, normal, reader, bool(animation))
    about = {"model_id": normal.model_id, "drivers": len(loaded.faces)}
    if animation is not None:
        about_film = provenance("retarget", [rig, neutral, *drivers], **about, fps=fps)
        _write_animation(animation, given, retargeting, fps, about_film)

    def retarget(path, target):
        row = loaded.row(path)
        with staged_face(target, **given, optional=seen_files(path, target)) as files:
            more = about | note_source(files[0], loaded.sources.get(path), path)
            _write(files, retargeting, row, provenance("retarget", [rig, path, neutral], **more))
        return f"{shown(target)}: {retargeting.describe(row)}"

    run_batch(ctx, jobs, retarget, "faces")


def _check_usage(drivers, neutral, animation, targets):
    """Refuse a mixture of drivers, a neutral face beside landmarks, and an animation with the name of a face."""
    from caricli.store.drivers import is_driving_mesh

    meshes = [is_driving_mesh(path) for path in drivers]
    if any(meshes) != all(meshes) or (neutral is not None and not meshes[0]):
        raise click.UsageError("Give either meshes, with or without --neutral, or landmarks without it.")
    if animation is not None and animation.with_suffix(".json") in [path.with_suffix(".json") for path in targets]:
        raise click.UsageError("--animation needs a name that no face has.")


def _film_files(animation):
    return [animation, animation.with_suffix(".json")]


def _check_outputs(out, out_dir, animation, given):
    """Refuse what cannot be written before the drivers are read, which takes its time."""
    check_outputs(*([] if out is None else face_files(out)), **given)
    check_outputs(*([] if animation is None else _film_files(animation)), **given)
    if out_dir is not None:
        check_folder(out_dir)


def _load_rig(path, normal, head):
    """The Rig of a file with the parts that are chosen. normal: MorphableModel. head: HeadChoice."""
    from caricli.methods.parts.whole_head import choose_head
    from caricli.store.drivers import load_driven_rig

    rig = load_driven_rig(path, normal)
    with naming(path):
        return choose_head(rig, head)


def _load(driven, drivers, neutral, normal, reader, whole):
    """The Drivers, and the Retargeting of those that could be read, or None.

    driven: Rig. normal: MorphableModel. reader: FaceReader. whole: whether a driver that cannot be read ends
    everything.
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.expressions.retarget_rig import retarget_rig
    from caricli.store.drivers import load_drivers
    from caricli.store.faces import load_face

    calm = None if neutral is None else load_face(neutral, normal).vertices
    with progress_bar("reading") as progress:
        loaded = load_drivers(drivers, normal, reader, progress, whole)
    return loaded, retarget_rig(list(loaded.faces.values()), driven, normal, calm) if loaded.faces else None


def _write(files, retargeting, row, description):
    """Write OBJ, NPZ, JSON and picture of a caricature with the expression of one driver."""
    from caricli.render.driver_sheet import driver_sheet
    from caricli.store.face_files import write_face_files

    obj_file, npz_file, json_file, png_file = files
    face = retargeting.caricature(row)
    write_face_files(obj_file, npz_file, face)
    write_json(json_file, description | retargeting.figures(row))
    write_picture(png_file, lambda: driver_sheet(_driver(retargeting, row), retargeting.rig, face.vertices))


def _driver(retargeting, row):
    """The normal face of a Retargeting as a whole head."""
    from caricli.methods.parts.whole_head import whole_head
    from caricli.structures import Face

    driver = retargeting.driver(row)
    return whole_head(Face(driver), driver)


def _write_animation(path, given, retargeting, fps, description):
    """Write GLB and JSON of the rig moving through all drivers, and say so. given: to ``staged``."""
    from caricli.io.gltf.write_gltf import write_gltf

    with staged(*_film_files(path), **given) as (glb, json_file):
        write_gltf(glb, retargeting.rig, animation=retargeting.animation(fps))
        write_json(json_file, description | {"weights": retargeting.weights_by_name()})
    echo_result(f"{shown(path)}: {description['drivers']} frames at {fps:.4g} a second")
