"""What reports say of pulled handles."""

from typing import Any

import numpy as np

from caricli.geometry.repair.self_intersections import self_intersections
from caricli.methods.edit.edit_handles import HandleEdit
from caricli.structures import Face


def handle_figures(edit: HandleEdit, before: Face) -> dict[str, Any]:
    """What the JSON says of an edit: every handle, how far the edit went, and what it did to the surface.

    before: Face that was edited.
    """
    handles = edit.handles
    rows = []
    for k, name in enumerate(handles.names):
        row = {
            "where": name,
            "vertex": int(handles.vertices[k]),
            "requested": handles.displacements[k],
            "achieved": edit.achieved[k],
        }
        reached = edit.reached[k]
        rows.append(row if np.isnan(reached) else row | {"reached": float(reached)})
    crossing = [len(self_intersections(face.vertices, face.faces)) for face in (before, edit.face)]
    return {
        "handles": rows,
        "share": edit.share,
        "energy_elsewhere": edit.elsewhere,
        "prior_rms": edit.face.prior_rms,
        "flipped_triangles": {"before": edit.flipped[0], "after": edit.flipped[1]},
        "crossing_pairs": {"before": crossing[0], "after": crossing[1]},
    }
