"""Blendshapes of a caricature as a rig, and what is said of them."""

from dataclasses import replace

import numpy as np

from caricli.methods.expressions.build_blendshapes import Blendshapes
from caricli.methods.expressions.measure_blendshapes import BlendshapeMeasures, measure_blendshapes
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.make_rig import RigResult, RigSettings, make_rig
from caricli.structures import Depiction, Face, Pictures
from caricli.structures.frame import AXES, UNITS


def rig_blendshapes(
    blendshapes: Blendshapes,
    tools: ExpressionTools,
    settings: RigSettings = RigSettings(),  # noqa: B008 (frozen)
    pictures: Pictures = Pictures(),  # noqa: B008 (frozen)
    worn: Face | None = None,
) -> RigResult:
    """The rig of a caricature's expressions, each of which starts from the neutral one.

    worn: Face of the caricature, whose polygons, UVs and hair it has, and whose camera shows it in its picture; without
    one the polygons and UVs of the model.
    Raises NumericsError for triangles without area.
    """
    neutral = blendshapes.shapes[0]
    face = (worn or Face(tools.morphable.template)).posed(neutral)
    result = make_rig(face.mesh, tools.acting, settings, pictures, blendshapes.shapes[1:] - neutral, worn)
    normal_deltas = (blendshapes.normal[1:] - blendshapes.normal[0]).astype(np.float32)
    depiction = None
    if worn is not None and worn.camera is not None:
        depiction = Depiction(worn.camera, result.shaped(worn).astype(np.float32), worn.landmarks)
    rig = replace(result.rig, normal_deltas=normal_deltas, depiction=depiction)
    return replace(result, rig=rig)


def report_blendshapes(
    face: Face, blendshapes: Blendshapes, tools: ExpressionTools, result: RigResult
) -> tuple[dict, str]:
    """Figures of every expression of a caricature, as JSON holds them, and one line that says the most important."""
    moves = blendshapes.shapes - face.vertices
    measures = measure_blendshapes(moves, blendshapes.normal - blendshapes.normal_given)
    return _figures(blendshapes, measures, tools, result), _describe(face, measures, result)


def _figures(blendshapes: Blendshapes, measures: BlendshapeMeasures, tools: ExpressionTools, result: RigResult) -> dict:
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
        "units": UNITS,
        "axes": AXES,
    }


def _describe(face: Face, measures: BlendshapeMeasures, result: RigResult) -> str:
    drift = 100 * np.nanmean(measures.drift) / face.mesh.height
    return (
        f"{len(result.rig.names)} expressions, {len(result.rig.neutral)} vertices, strength "
        f"{np.nanmean(measures.strength):.2f} of a normal face's, drift {drift:.3f} %, flipped triangles at most "
        f"{100 * result.measures.flipped.max():.3f} %"
    )
