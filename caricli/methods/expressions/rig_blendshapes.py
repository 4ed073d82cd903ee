"""Blendshapes of a caricature as a rig, and what is said of them."""

from dataclasses import replace

import numpy as np

from caricli.methods.expressions.build_blendshapes import Blendshapes
from caricli.methods.expressions.measure_blendshapes import BlendshapeMeasures, measure_blendshapes
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.make_rig import Pictures, RigResult, RigSettings, assemble_rig
from caricli.structures import Face, Rig


def rig_blendshapes(
    blendshapes: Blendshapes,
    tools: ExpressionTools,
    settings: RigSettings = RigSettings(),  # noqa: B008 (frozen)
    pictures: Pictures = Pictures(),  # noqa: B008 (frozen)
) -> RigResult:
    """The rig of a caricature's expressions, each of which starts from the neutral one.

    Raises NumericsError for triangles without area.
    """
    neutral = blendshapes.shapes[0]
    mesh = tools.morphable.template.with_vertices(neutral)
    result = assemble_rig(mesh, tools.acting, blendshapes.shapes[1:] - neutral, settings, pictures)
    normal_deltas = (blendshapes.normal[1:] - blendshapes.normal[0]).astype(np.float32)
    return replace(result, rig=replace(result.rig, normal_deltas=normal_deltas))


def shape_as_given(rig: Rig, face: Face) -> np.ndarray:
    """(W, 3) the vertices of a rig with the expression that the caricature has in its picture."""
    given = np.array(rig.neutral)
    given[: len(face.vertices)] = face.vertices
    return given


def measure_expressions(blendshapes: Blendshapes, face: Face) -> BlendshapeMeasures:
    """How well the expressions of a caricature keep who it is and show what they are."""
    return measure_blendshapes(blendshapes.shapes - face.vertices, blendshapes.normal - blendshapes.normal_given)


def blendshape_figures(
    blendshapes: Blendshapes, measures: BlendshapeMeasures, tools: ExpressionTools, result: RigResult
) -> dict:
    """Figures of every expression, as JSON holds them."""
    rows = {}
    for k, (name, weights) in enumerate(tools.expressions.items()):
        values = {"drift": measures.drift[k], "strength": measures.strength[k], "excess": measures.excess[k]}
        if k:
            # The rig starts from the neutral expression, which it does not count.
            values["flipped"] = result.measures.flipped[k - 1]
            values["contact_gap"] = result.measures.contact_gap[k - 1]
        rows[name] = {"weights": weights} | {key: float(v) for key, v in values.items() if np.isfinite(v)}
    return {
        "expressions": rows,
        "structure": measures.structure,
        "normal_face": {"nme": blendshapes.fit.nme, "prior_rms": blendshapes.fit.prior_rms},
        "units": "m",
        "axes": "+y up, +z front",
    }


def describe_blendshapes(face: Face, measures: BlendshapeMeasures, result: RigResult) -> str:
    """One line: how many expressions, how strong they are, how much they change who it is."""
    drift = 100 * np.nanmean(measures.drift) / face.mesh.height
    return (
        f"{len(result.rig.names)} expressions, {len(result.rig.neutral)} vertices, strength "
        f"{np.nanmean(measures.strength):.2f} of a normal face's, drift {drift:.3f} %, flipped triangles at most "
        f"{100 * result.measures.flipped.max():.3f} %"
    )
