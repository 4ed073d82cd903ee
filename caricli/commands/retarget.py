"""caricli retarget: a caricature that does what a normal face does."""

import click
import numpy as np

from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    face_files,
    model_option,
    named,
    out_folder_option,
    out_option,
    overwrite_option,
)
from caricli.errors import CaricliError, InputError, shown
from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.obj import write_obj
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.rig import read_rig
from caricli.io.strict_json import write_json
from caricli.structures import Face

SIZE = 384
_MESHES, _SAID, _SEEN = (".obj", ".npz"), 3, 0.05


@click.command()
@click.argument("rig", type=PATH, metavar="B.npz")
@click.argument("drivers", nargs=-1, required=True, type=PATH, metavar="NORMAL_FACE|LANDMARKS...")
@out_option("FACE.obj", "The result of one driver; FACE.npz, .json and .png are written beside it.", required=False)
@out_folder_option("The results of many drivers, each under the name of its file.")
@click.option("--neutral", type=PATH, metavar="FACE", help="The neutral face of the person in the driving meshes.")
@click.option("--animation", type=PATH, metavar="ANIM.glb", callback=named(".glb"),
              help="The rig moving through all drivers in their order; ANIM.json is written beside it.")  # fmt: skip
@click.option("--fps", type=FiniteRange(0, 240, min_open=True), default=25, metavar="N", help="Drivers a second.")
@model_option
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@overwrite_option
@click.pass_context
def command(ctx, rig, drivers, out, out_dir, neutral, animation, fps, model, pts_origin, overwrite):
    """Give a caricature the expressions of normal faces: meshes of the model's topology (OBJ or NPZ), or landmarks.

    B.npz is what `blendshapes` wrote. Weights from 0 to 1.5 explain what a driver does to a normal face, and are
    applied to the caricature. All drivers are of one person and of one kind. Place and size do not matter. Weights of
    meshes are exact with --neutral; without it, and from landmarks, who somebody is and what he does are told apart by
    what is likely.

    \b
    Example:
      caricli retarget b.npz smile.obj --neutral calm.obj --out smiling.obj
      caricli retarget b.npz photo.json --out face.obj
      caricli retarget b.npz take/*.obj --neutral calm.obj --out-dir frames --animation take.glb --fps 30
    """
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.store.models import load_model

    jobs = named_jobs(drivers, "NORMAL_FACE", out, out_dir, ".obj")
    meshes = [path.suffix.lower() in _MESHES for path in drivers]
    if any(meshes) != all(meshes) or (neutral is not None and not meshes[0]):
        raise click.UsageError("Give either meshes, with or without --neutral, or landmarks without it.")
    if animation is not None and animation.with_suffix(".obj") in [target for _, target in jobs]:
        raise click.UsageError("--animation needs a name that no face has.")
    shape_model = load_model(model, "morphable")
    if shape_model.kind != "morphable":
        raise InputError(f"{shown(model)}: expected a model of kind morphable, found {shape_model.kind}")
    moving, inputs = _load(rig, shape_model), (rig, neutral, model, *drivers)
    known, failed, explained = _explained(drivers, moving, shape_model, neutral, pts_origin, animation is not None)
    unit = "mm" if meshes[0] else "percent"
    about = {"model_id": shape_model.model_id, "drivers": len(known)}
    if animation is not None:
        with staged(animation, animation.with_suffix(".json"), overwrite=overwrite, inputs=inputs) as files:
            description = provenance("retarget", [rig, neutral, *drivers], **about, fps=fps)
            _write_animation(files, moving, explained.weights, fps, description)
        click.echo(f"{shown(animation)}: {len(drivers)} frames at {fps:.4g} a second")

    def retarget(path, target):
        if path in failed:
            raise failed[path]
        row = known.index(path)
        weights, left = explained.weights[row], explained.errors[row]
        with staged(*face_files(target), overwrite=overwrite, inputs=inputs) as files:
            figures = {"weights": dict(zip(moving.names, weights.tolist(), strict=True)), f"left_{unit}": float(left)}
            description = provenance("retarget", [rig, path, neutral], **about, **figures)
            _write(files, moving, weights, explained.neutral, shape_model.template, description)
        return f"{shown(target)}: {_said(moving.names, weights)}; {left:.2f} {unit} unexplained"

    run_batch(ctx, jobs, retarget, "faces")


def _load(path, model):
    """The Rig of a file whose normal face is the model's."""
    rig, count = read_rig(path), len(model.mean)
    if rig.normal_deltas is None:
        raise InputError(
            f"{shown(path)}: expected a rig that says what its expressions do to a normal face, found none; "
            "caricli blendshapes writes one"
        )
    if rig.normal_deltas.shape[1] != count:
        found = rig.normal_deltas.shape[1]
        raise InputError(f"{shown(path)}: expected normal_deltas of the model's {count} vertices, found {found}")
    if not rig.normal_deltas.any():
        raise InputError(f"{shown(path)}: expected expressions that move a normal face, found none that does")
    return rig


def _explained(drivers, rig, model, neutral, pts_origin, whole):
    """The drivers that could be read, the errors of the others by path, and the Explanation of the former.

    whole: whether a driver that cannot be read ends everything.
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.expressions.retarget_expression import explain_landmarks, explain_meshes
    from caricli.methods.reconstruct.fit_morphable import fit_morphable
    from caricli.store.faces import load_face

    known, failed = {}, {}
    calm = None if neutral is None else load_face(neutral, model).vertices
    meshes = drivers[0].suffix.lower() in _MESHES
    with progress_bar("reading") as progress:
        for number, path in enumerate(drivers):
            try:
                if meshes:
                    known[path] = load_face(path, model).vertices
                else:
                    points = read_landmarks(path, pts_origin).points
                    known[path] = fit_morphable(points, model), points
            except CaricliError as error:
                failed[path] = error if str(path) in str(error) else InputError(f"{shown(path)}: {error}")
                if whole:
                    raise failed[path] from error
            progress(number + 1, len(drivers))
    if not known:
        return [], failed, None
    if meshes:
        return [*known], failed, explain_meshes([*known.values()], rig.normal_deltas, model, calm)
    return [*known], failed, explain_landmarks(*zip(*known.values(), strict=True), rig.normal_deltas, model)


def _write(files, rig, weights, neutral, template, description):
    """Write OBJ, NPZ, JSON and picture of a caricature with an expression."""
    from caricli.methods.animate.pose_rig import RigPoser
    from caricli.render.contact_sheet import contact_sheet
    from caricli.render.draw_rig import draw_rig
    from caricli.render.head_views import head_views

    obj_file, npz_file, json_file, png_file = files
    vertices = RigPoser(rig).pose(weights).astype(float)
    mesh = rig.mesh.with_vertices(vertices)
    write_obj(obj_file, mesh)
    write_face(npz_file, Face(mesh))
    write_json(json_file, description)
    driver = neutral + np.tensordot(weights, rig.normal_deltas, 1)
    pictures = head_views(template.with_vertices(driver), ("front",), SIZE)
    pictures.append(draw_rig(rig, vertices, "front", SIZE))
    write_png(png_file, contact_sheet(pictures, 2, ["driver", "caricature"]))


def _write_animation(files, rig, weights, fps, description):
    """Write the GLB and its JSON."""
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.structures import Animation

    glb, json_file = files
    write_gltf(glb, rig, animation=Animation(np.arange(len(weights)) / fps, weights))
    values = dict(zip(rig.names, weights.T.tolist(), strict=True))
    write_json(json_file, description | {"weights": values})


def _said(names, weights):
    """The strongest expressions."""
    strong = [k for k in np.argsort(-weights, kind="stable") if weights[k] >= _SEEN]
    more = f" and {len(strong) - _SAID} more" if len(strong) > _SAID else ""
    return (", ".join(f"{names[k]} {weights[k]:.2f}" for k in strong[:_SAID]) or "no expression") + more
