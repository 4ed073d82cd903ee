"""What is said of a rig."""

import numpy as np

from caricli.methods.rig.make_rig import RigResult

APART = 0.12
"""Share of an open mouth: lips that are farther apart in the neutral face stay so in most expressions."""


def rig_figures(result: RigResult, actions: dict[str, dict]) -> dict:
    """Figures of every expression, of lids, lips and eyes, as JSON holds them.

    actions: what is known of expressions by name, such as their action units.
    """
    measures = result.measures
    rows = {}
    for k, name in enumerate(result.rig.names):
        values = {"strength": measures.strength[k], "contact_gap": measures.contact_gap[k]}
        rows[name] = {key: float(value) for key, value in values.items() if np.isfinite(value)}
        rows[name] |= {"flipped": float(measures.flipped[k])} | actions.get(name, {})
    gaps = {"lid_gap": measures.lid_gap, "lip_gap": measures.lip_gap, "lids_inside_eyeballs": measures.inside}
    eyes = [{"side": b.side, "centre": b.centre, "radius": b.radius, "retreat": b.retreat} for b in result.eyeballs]
    return {"expressions": rows} | {k: v for k, v in gaps.items() if v not in (None, {})} | {"eyeballs": eyes}


def describe_rig(result: RigResult) -> str:
    """One line: how many expressions, how well lids and lips close, how many triangles turn over at most."""
    measures = result.measures
    moving = int(np.isfinite(measures.strength).sum())
    words = [f"{len(result.rig.names)} expressions ({moving} move), {len(result.rig.neutral)} vertices"]
    if measures.lid_gap:
        words.append(f"lids close to {100 * max(measures.lid_gap.values()):.1f} %")
    if measures.lip_gap is not None:
        words.append(f"lips to {100 * measures.lip_gap:.1f} %")
    return ", ".join([*words, f"flipped triangles at most {100 * measures.flipped.max():.3f} %"])


def lips_are_apart(result: RigResult) -> bool:
    """Whether the neutral face opens its mouth."""
    return result.measures.lips_open is not None and result.measures.lips_open > APART
