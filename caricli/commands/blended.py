"""What `caricli blendshapes` reads, makes of it and writes besides its options."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.commands.loading import DEFAULT_LATENT, face_pose, load_face, load_model
from caricli.commands.rigging import expression_sheet, face_pictures, load_templates
from caricli.data.expressions import NEUTRAL, facs_expressions, read_expressions
from caricli.errors import InputError
from caricli.geometry.scaled_orthographic_pose import Pose
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.face import topology_id
from caricli.io.files import shown
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks
from caricli.methods.build_rig import build_rig
from caricli.methods.expression_templates import ExpressionTemplates, combined_templates
from caricli.methods.fit_landmarks import fit_landmarks
from caricli.methods.measure_blendshapes import measure_blendshapes
from caricli.models.landmark_map import LandmarkMap, map_from_checkpoint
from caricli.models.morphable import MorphableModel


@dataclass(frozen=True, eq=False)
class BlendJob:
    """A caricature and what its expressions are made with.

    vertices (V, 3) with its own expression; pose of its picture; expressions, dict from names to weights of actions;
    templates of them, the neutral one first; model, ShapeModel for latent reconstruction, or None; picture and eyes,
    (H, W, 3) for skin and eyes, or None; inputs, the paths that were read.
    """

    vertices: np.ndarray
    pose: Pose
    expressions: dict
    templates: ExpressionTemplates
    morphable: MorphableModel
    landmark_map: LandmarkMap
    model: object
    picture: np.ndarray | None
    eyes: np.ndarray | None
    inputs: list

    def rig(self, made, generator, eyeballs):
        """Rig, RigMeasures and Eyeballs of Blendshapes: every expression starts from the neutral one."""
        mesh, neutral = self.morphable.template.with_vertices(made.shapes[0]), made.normal[0]
        acting = replace(self.templates, names=self.templates.names[1:], deltas=self.templates.deltas[1:])
        deltas = made.shapes[1:] - made.shapes[0]
        rig, *rest = build_rig(mesh, acting, deltas, generator, 0, eyeballs, self.picture, self.eyes)
        return replace(rig, normal_deltas=(made.normal[1:] - neutral).astype(np.float32)), *rest


def load_job(source, expressions, map_path, model, templates, reconstruct, texture, pts_origin):
    """The BlendJob of the command's arguments. Raises InputError."""
    morphable = load_model(model, "morphable")
    if morphable.kind != "morphable":
        raise InputError(f"{shown(model)}: expected a model of kind morphable, found {morphable.kind}")
    known, _, used = load_templates(templates)
    if topology_id(known.faces) != morphable.template.topology_id:
        counts = len(morphable.template.vertices), len(known.neutral)
        raise InputError(f"expected templates of the model's mesh ({counts[0]} vertices), found {counts[1]} vertices")
    chosen = facs_expressions(known.names) if templates is None else {NEUTRAL: {}} | {n: {n: 1.0} for n in known.names}
    if expressions is not None:
        chosen = read_expressions(expressions, known.names)
    map_path = map_path or asset_path("landmark_map.safetensors")
    landmark_map = map_from_checkpoint(*read_checkpoint(map_path), shown(map_path))
    skin, eyes = texture, None
    if source.suffix.lower() == ".npz":
        face = load_face(source, morphable)
        vertices, pose = face.vertices, face_pose(face, source)
        skin, eyes = face_pictures(source, texture)
    else:
        fit = fit_landmarks(read_landmarks(source, pts_origin).points, load_model())
        vertices, pose = fit.vertices, fit.pose
    latent = load_model(kind=DEFAULT_LATENT) if reconstruct == "latent" else None
    if len(vertices) != len(morphable.mean) or (latent and latent.template.topology_id != topology_id(known.faces)):
        raise InputError(f"{shown(model)}: its mesh is not that of the bundled models; give a FACE.npz of its own")
    pictures = [path and read_image(path) for path in (skin, eyes)]
    inputs = [path for path in (source, expressions, model, map_path, skin, eyes, *used) if path is not None]
    set_of = combined_templates(known, chosen)
    return BlendJob(vertices.astype(float), pose, chosen, set_of, morphable, landmark_map, latent, *pictures, inputs)


def report(job, made, rig, measures):
    """What the JSON says of Blendshapes, and the line to print."""
    moves = measure_blendshapes(made.shapes - job.vertices, made.normal - made.normal_given)
    rows = {}
    for k, (name, weights) in enumerate(job.expressions.items()):
        values = {"drift": moves.drift[k], "strength": moves.strength[k], "excess": moves.excess[k]}
        if k:
            values |= {"flipped": measures.flipped[k - 1], "contact_gap": measures.contact_gap[k - 1]}
        rows[name] = {"weights": weights} | {key: float(v) for key, v in values.items() if np.isfinite(v)}
    figures = {
        "expressions": rows,
        "structure": moves.structure,
        "normal_face": {"nme": made.fit.nme, "prior_rms": made.fit.prior_rms},
        "units": "m",
        "axes": "+y up, +z front",
    }
    drift = 100 * np.nanmean(moves.drift) / np.ptp(job.vertices[:, 1])
    line = (
        f"{len(rig.names)} expressions, {len(rig.neutral)} vertices, strength {np.nanmean(moves.strength):.2f} of a "
        f"normal face's, drift {drift:.3f} %, flipped triangles at most {100 * measures.flipped.max():.3f} %"
    )
    return figures, line


def write_sheet(path, job, rig, progress):
    """The picture of all expressions, with the one of the picture before them."""
    given = np.array(rig.neutral)
    given[: len(job.vertices)] = job.vertices
    write_png(path, expression_sheet(rig, progress, given))
