"""What `caricli blendshapes` reads, makes of it and writes besides its options."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.commands.rigging import face_pictures
from caricli.data.expressions import NEUTRAL, facs_expressions, read_expressions
from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.image import read_image
from caricli.io.landmarks import read_landmarks
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.measure_blendshapes import measure_blendshapes
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.rig.build_rig import build_rig
from caricli.methods.rig.expression_templates import ExpressionTemplates, combined_templates
from caricli.models.landmark_map.model import LandmarkMap, map_from_checkpoint
from caricli.models.morphable.model import MorphableModel
from caricli.store.expression_templates import load_templates
from caricli.store.faces import face_camera, load_face
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import Camera
from caricli.structures.mesh import topology_id


@dataclass(frozen=True, eq=False)
class BlendTools:
    """What expressions are made with: actions, ExpressionTemplates; expressions, dict from names to weights of actions;
    templates of these, the neutral one first; latent, ShapeModel for latent reconstruction, or None; inputs, the paths
    that were read."""

    actions: ExpressionTemplates
    expressions: dict
    templates: ExpressionTemplates
    morphable: MorphableModel
    landmark_map: LandmarkMap
    latent: object
    inputs: list

    @cached_property
    def acting(self):
        """The templates without the neutral one; what they find out of themselves is kept for every rig."""
        return replace(self.templates, names=self.templates.names[1:], deltas=self.templates.deltas[1:])

    def rig(self, made, generator, eyeballs=True, pictures=(None, None)):
        """Rig, RigMeasures and Eyeballs of Blendshapes: every expression starts from the neutral one.

        pictures: (H, W, 3) uint8 for skin and eyes, or None.
        """
        mesh, neutral = self.morphable.template.with_vertices(made.shapes[0]), made.normal[0]
        deltas = made.shapes[1:] - made.shapes[0]
        rig, *rest = build_rig(mesh, self.acting, deltas, generator, 0, eyeballs, *pictures)
        return replace(rig, normal_deltas=(made.normal[1:] - neutral).astype(np.float32)), *rest


@dataclass(frozen=True, eq=False)
class Caricature:
    """vertices (V, 3) with an expression of their own; pose of their picture; pictures of skin and eyes, (H, W, 3) or
    None each; inputs, the paths that were read."""

    vertices: np.ndarray
    pose: Camera
    pictures: tuple
    inputs: list


def load_tools(expressions=None, map_path=None, model=None, templates=None, reconstruct="intrinsic"):
    """The BlendTools of paths, or None for what is bundled. Raises InputError."""
    morphable = load_model(model, "morphable")
    if morphable.kind != "morphable":
        raise InputError(f"{shown(model)}: expected a model of kind morphable, found {morphable.kind}")
    known, _, used = load_templates(templates)
    latent = load_model(kind=DEFAULT_LATENT) if reconstruct == "latent" else None
    for ids in [topology_id(known.faces), *([latent.template.topology_id] if latent else [])]:
        if ids != morphable.template.topology_id:
            expected = f"templates and models of one mesh, that of the morphable model ({len(morphable.mean)} vertices)"
            raise InputError(f"{shown(model or templates)}: expected {expected}, found another")
    chosen = facs_expressions(known.names) if templates is None else {NEUTRAL: {}} | {n: {n: 1.0} for n in known.names}
    if expressions is not None:
        chosen = read_expressions(expressions, known.names)
    combined = combined_templates(known, chosen)
    if not combined.deltas.any():
        raise InputError(f"{shown(expressions)}: expected expressions that move something, found none")
    map_path = map_path or asset_path("landmark_map.safetensors")
    landmark_map = map_from_checkpoint(*read_checkpoint(map_path), shown(map_path))
    inputs = [path for path in (expressions, model, map_path, *used) if path is not None]
    return BlendTools(known, chosen, combined, morphable, landmark_map, latent, inputs)


def load_caricature(source, morphable, texture=None, pts_origin=1):
    """The Caricature of a face (NPZ), or of landmarks, which are reconstructed. Raises InputError."""
    if source.suffix.lower() == ".obj":
        raise InputError(f"{shown(source)}: expected FACE.npz or landmarks, found an OBJ, which has no camera")
    if source.suffix.lower() == ".npz":
        face = load_face(source, morphable)
        vertices, pose, paths = face.vertices, face_camera(face, source), face_pictures(source, texture)
    else:
        intrinsic = load_model()
        if intrinsic.template.topology_id != morphable.template.topology_id:
            raise InputError(f"{shown(source)}: expected a FACE.npz for a model of another mesh, found landmarks")
        fit = fit_landmarks(read_landmarks(source, pts_origin).points, intrinsic)
        vertices, pose, paths = fit.vertices, fit.pose, (texture, None)
    pictures = tuple(path and read_image(path) for path in paths)
    inputs = [path for path in (source, *paths) if path is not None]
    return Caricature(vertices.astype(float), pose, pictures, inputs)


def build(tools, face, method="full", weights=None):
    """Blendshapes of a Caricature by a method of ``build_blendshapes``."""
    known = tools.templates, tools.morphable, tools.landmark_map
    return build_blendshapes(face.vertices, face.pose, *known, method, weights, tools.latent)


def report(tools, face, made, rig, measures):
    """What the JSON says of Blendshapes, and the line to print."""
    moves = measure_blendshapes(made.shapes - face.vertices, made.normal - made.normal_given)
    rows = {}
    for k, (name, weights) in enumerate(tools.expressions.items()):
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
    drift = 100 * np.nanmean(moves.drift) / np.ptp(face.vertices[:, 1])
    line = (
        f"{len(rig.names)} expressions, {len(rig.neutral)} vertices, strength {np.nanmean(moves.strength):.2f} of a "
        f"normal face's, drift {drift:.3f} %, flipped triangles at most {100 * measures.flipped.max():.3f} %"
    )
    return figures, line


def with_given(rig, face):
    """(W, 3) the vertices of a Rig with the expression that the Caricature has in its picture."""
    given = np.array(rig.neutral)
    given[: len(face.vertices)] = face.vertices
    return given
